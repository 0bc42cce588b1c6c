// Stands last in the page under test: uses the page as a reader does, and writes what came of it
// into the page.
(async () => {
  const frame = () => new Promise((resolve) => setTimeout(resolve, 120));
  const found = {};
  try {
    await frame();
    // Every figure has its curves, inside of the picture.
    found.figures = {};
    for (const node of document.querySelectorAll("figure")) {
      const curves = [...node.querySelectorAll(".curve")].map((curve) => curve.getAttribute("d"));
      // A run of one iteration is a mark without a line.
      const marks = node.querySelectorAll("circle").length;
      const fine = curves.every((d) => /^M[^N]*$/.test(d) && (d.includes("L") || marks >= curves.length));
      found.figures[node.dataset.key] = fine ? curves.length : -1;
    }
    const image = () => {
      const canvas = document.getElementById("stage");
      const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
      let sum = 0;
      for (let k = 0; k < pixels.length; k++) sum = (sum * 31 + pixels[k]) >>> 0;
      return sum;
    };
    const slider = document.getElementById("slider");
    if (slider) {
      const images = [];
      for (const at of [0, 400, 1000]) {
        slider.value = at;
        slider.dispatchEvent(new Event("input", { bubbles: true }));
        await frame();
        images.push(image());
      }
      found.images = new Set(images).size;
      found.clock = document.getElementById("clock").textContent;
      // Turned by hand it looks different too.
      const canvas = document.getElementById("stage");
      canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
      await frame();
      found.turns = image() !== images[2];
    }
    // Angles of every sequence at one time, and the quaternion there.
    const choice = document.querySelector("#fig-euler select");
    if (choice) {
      slider.value = 400;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
      const values = (key) => [...document.querySelectorAll(`#fig-${key} .legend b`)].map((node) => node.textContent);
      found.quaternion = values("quaternion");
      found.euler = {};
      for (const option of choice.options) {
        choice.value = option.value;
        choice.dispatchEvent(new Event("change", { bubbles: true }));
        await frame();
        const title = document.querySelector("#fig-euler b").textContent;
        found.euler[title.slice(-3)] = values("euler");
      }
    }
    // Keys move the cursor of every chart over time and zoom into them.
    const plot = document.querySelector("#fig-rates .plot");
    if (plot) {
      const key = (key) => plot.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
      key("Escape");
      key("ArrowRight");
      await frame();
      found.values = [...document.querySelectorAll("#fig-rates .legend b")].map((node) => node.textContent);
      found.shared = document.querySelector("#fig-quaternion .legend").textContent.includes("at ");
      const curve = () => document.querySelector("#fig-rates .curve").getAttribute("d");
      const before = curve();
      key("+");
      await frame();
      found.zooms = curve() !== before;
      key("0");
      await frame();
      found.unzooms = curve() === before;
    }
    found.title = document.querySelector("h1").textContent;
    found.verdict = document.querySelector(".verdict").textContent;
    found.width = [document.documentElement.scrollWidth, window.innerWidth];
    found.scripts = document.querySelectorAll("script").length;
    // What a name of a spec might have smuggled in.
    found.smuggled = window.smuggled === undefined && !document.querySelector("img");
  } catch (error) {
    wrong.push(`check: ${error.stack}`);
  }
  found.wrong = wrong;
  const pre = document.createElement("pre");
  pre.id = "check";
  pre.textContent = JSON.stringify(found);
  document.body.appendChild(pre);
})();
