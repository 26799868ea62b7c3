// A worker that runs the loop off the page's main thread.
//
// It is told a task once, and `stop`; it tells what course.js tells. A run that blocks hears no
// `stop` and looks at its alarm instead.

import { beginCourse } from "./course.js";

let course = null;

addEventListener("message", ({ data }) => {
  if (data.stop) {
    course?.stop();
  } else {
    course = beginCourse(data.task, tell);
  }
});

function tell(event) {
  const moved = event.event === "progress" ? [event.sends.buffer, event.ends.buffer] : [];
  postMessage(event, { transfer: moved });
}
