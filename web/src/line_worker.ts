// The worker of a live print's tab: nothing that the page draws delays its commands.

import {LineEnd} from "./data/line_end";

const end = new LineEnd(message => postMessage(message));
addEventListener("message", event => end.take(event.data));
postMessage({kind: "ready"});
