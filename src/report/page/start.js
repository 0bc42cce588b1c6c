// Draws everything that the page has a place for.

for (const picture of data.charts) {
  const node = document.getElementById(`fig-${picture.key}`);
  if (picture.kind === "sky") sky(node, picture);
  else chart(node, picture);
}
if (data.body) stage();
