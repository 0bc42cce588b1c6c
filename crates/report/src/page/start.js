// Draws everything that the page has a place for.

for (const picture of data.charts) {
  const node = document.getElementById(`fig-${picture.key}`);
  if (picture.kind === "sky") sky(node, picture);
  else {
    const replace = chart(node, picture);
    if (picture.key === "euler" && data.body) eulerChoice(node, picture, replace);
  }
}
if (data.body) stage();
