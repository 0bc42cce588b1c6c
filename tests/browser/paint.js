// Stands last in the page under test: tells, in milliseconds, when something was seen first and
// when all was drawn.
new PerformanceObserver((list) => {
  for (const entry of list.getEntriesByName("first-contentful-paint")) {
    requestAnimationFrame(() => setTimeout(() => {
      console.log(`PAINT ${JSON.stringify({ first: entry.startTime, drawn: performance.now() })}`);
    }));
  }
}).observe({ type: "paint", buffered: true });
