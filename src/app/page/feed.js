// SPDX-License-Identifier: Apache-2.0
// What the page reads, and when: the status once a second, and one stream of events, both only while somebody can see the
// page. mbgated takes no samples of its own: what is plotted was asked for here.

const STATUS = "/api/v1/status";
const STREAM = "/api/v1/trace?events=1";
const INTERVAL = 1000;  // ms
const LIMIT = 3000;  // ms: mbgated itself says after one second that the gateway does not answer
const AGAIN = 3000;  // ms, after the stream has failed

export class Feed {
  /** `observer`: { status(json, age), silent(why), record(kind, json), line(id, json), lost(count), gap(), stream(isOpen) } */
  constructor(observer) {
    this.observer = observer;
    document.addEventListener("visibilitychange", () => this.follow());
    window.addEventListener("pagehide", () => this.stop());
    window.addEventListener("pageshow", () => this.follow());
    this.follow();
  }

  follow() {
    if (document.hidden) {
      this.stop();
    } else if (!this.aborter) {
      this.observer.gap();
      this.aborter = new AbortController();
      this.ask(this.aborter.signal);
      this.listen();
    }
  }

  stop() {
    this.aborter?.abort();
    this.aborter = null;
    clearTimeout(this.next);
    clearTimeout(this.again);
    this.stream?.close();
    this.stream = null;
  }

  async ask(signal) {
    const began = performance.now();
    const own = new AbortController();
    const giveUp = () => own.abort();
    const timer = setTimeout(giveUp, LIMIT);
    signal.addEventListener("abort", giveUp);
    try {
      const response = await fetch(STATUS, { cache: "no-store", signal: own.signal });
      const json = await response.json();
      if (response.ok) {
        this.observer.status(json);
      } else {
        this.observer.silent(json.error ?? `HTTP ${response.status}`);
      }
    } catch (error) {
      if (!signal.aborted) {
        this.observer.silent(own.signal.aborted ? "mbgated does not answer" : "mbgated cannot be reached");
      }
    }
    clearTimeout(timer);
    signal.removeEventListener("abort", giveUp);
    if (!signal.aborted) {
      this.next = setTimeout(() => this.ask(signal), Math.max(0, INTERVAL - (performance.now() - began)));
    }
  }

  listen() {
    const stream = new EventSource(STREAM);
    this.stream = stream;
    for (const kind of ["transaction", "frame", "heard"]) {
      stream.addEventListener(kind, (event) => this.observer.record(kind, JSON.parse(event.data)));
    }
    stream.addEventListener("journal", (event) => this.observer.line(event.lastEventId, JSON.parse(event.data)));
    stream.addEventListener("lost", (event) => this.observer.lost(JSON.parse(event.data).lost));
    stream.addEventListener("open", () => this.observer.stream(true));
    stream.addEventListener("error", () => {
      stream.close();  // its own way of trying again gives up after an answer like 503
      this.observer.stream(false);
      if (this.stream === stream) {
        this.again = setTimeout(() => this.listen(), AGAIN);
      }
    });
  }
}
