// What a page does beside the loop, on its own thread: it draws, as a page does that people look at and click on.

/** How often it has something to do. */
const EVERY_MS = 100;
/** Side of the picture, in pixels. */
const SIDE = 256;

/** Draws for so long of each 100 ms, until what it gives is called. */
export function beginChores(chores_ns) {
  const long_ms = chores_ns / 1e6;
  if (long_ms === 0) {
    return () => {};
  }
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = SIDE;
  // Read after each stroke, so that it is drawn then: a browser else only notes it, and draws for much longer later.
  const picture = canvas.getContext("2d", { willReadFrequently: true });
  const draw = () => {
    for (const end_ms = performance.now() + long_ms; performance.now() < end_ms; ) {
      picture.beginPath();
      picture.arc(SIDE / 2, SIDE / 2, Math.random() * (SIDE / 2), 0, 2 * Math.PI);
      picture.stroke();
      picture.getImageData(0, 0, 1, 1);
    }
  };
  const timer = setInterval(draw, EVERY_MS);
  return () => clearInterval(timer);
}
