// What this browser grants to the thread that asks: the clock's step and the timers' clamp.
//
// Measured before the start, in some 150 ms, in the thread that will run the loop.

/** How long the clock is watched. */
const WATCH_MS = 10;
/** Timers set by timers before the clamp acts; the standard says more than 5. */
const NESTINGS = 10;
/** Timers that are measured after that. */
const MEASURED = 15;

/** The least step of performance.now() in microseconds. */
export function clockStep_us() {
  const end_ms = performance.now() + WATCH_MS;
  let least_ms = Infinity;
  let last_ms = performance.now();
  while (last_ms < end_ms) {
    const now_ms = performance.now();
    if (now_ms > last_ms) {
      least_ms = Math.min(least_ms, now_ms - last_ms);
      last_ms = now_ms;
    }
  }
  return Math.round(least_ms * 1e6) / 1e3;
}

/** What setTimeout(0) really takes when nested, the median in milliseconds. */
export async function timerClamp_ms() {
  const spans_ms = await new Promise((resolve) => {
    const spans = [];
    let fired = 0;
    let last_ms = performance.now();
    const fire = () => {
      const now_ms = performance.now();
      fired += 1;
      if (fired > NESTINGS) {
        spans.push(now_ms - last_ms);
      }
      last_ms = now_ms;
      if (spans.length < MEASURED) {
        // Set by the timer itself: a promise in between would begin a new chain.
        setTimeout(fire, 0);
      } else {
        resolve(spans);
      }
    };
    setTimeout(fire, 0);
  });
  spans_ms.sort((a, b) => a - b);
  return Math.round(spans_ms[Math.floor(MEASURED / 2)] * 1e3) / 1e3;
}
