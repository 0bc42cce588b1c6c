// Stands first in the page under test: notes what goes wrong from then on.
window.wrong = [];
addEventListener("error", (event) => wrong.push(String(event.message)));
addEventListener("unhandledrejection", (event) => wrong.push(String(event.reason)));
addEventListener("securitypolicyviolation", (event) => wrong.push(`policy: ${event.violatedDirective}`));
for (const level of ["error", "warn"]) {
  const was = console[level];
  console[level] = (...what) => {
    wrong.push(what.join(" "));
    was.apply(console, what);
  };
}
