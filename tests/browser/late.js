/**
 * Everything comes late: what the server says, what it is told, what is fetched, and every redraw.
 * Each kind keeps its order.
 * @param {number} ms in the mean; a single wait is between half of it and one and a half times as
 *   long, and that for a redraw a quarter of it
 */
(ms) => {
  const REDRAW = 0.25; // what moves is still seen to move
  let seed = 1;
  const wait = () => {
    seed = (Math.imul(seed, 1103515245) + 12345) >>> 0;
    return ms * (0.5 + seed / 2 ** 32);
  };

  /** Runs what it is given after a wait, and never before what it was given earlier. */
  const newQueue = (share = 1) => {
    const tasks = [];
    let free = 0;
    return (task) => {
      tasks.push(task);
      const now = performance.now();
      free = Math.max(free, now + share * wait());
      setTimeout(() => tasks.shift()(), free - now);
    };
  };

  const queues = new WeakMap();
  const queueOf = (socket, way) => {
    if (!queues.has(socket)) queues.set(socket, { heard: newQueue(), sent: newQueue() });
    return queues.get(socket)[way];
  };

  const handlers = new WeakMap();
  for (const name of ['onmessage', 'onclose']) {
    const usual = Object.getOwnPropertyDescriptor(WebSocket.prototype, name);
    Object.defineProperty(WebSocket.prototype, name, {
      ...usual,
      set(handler) {
        const mine = handlers.get(this) ?? {};
        handlers.set(this, { ...mine, [name]: handler });
        // Whoever has stopped listening meanwhile is told nothing.
        usual.set.call(this, (event) =>
          queueOf(this, 'heard')(() => handlers.get(this)[name]?.call(this, event)),
        );
      },
    });
  }

  const send = WebSocket.prototype.send;
  WebSocket.prototype.send = function (...data) {
    queueOf(this, 'sent')(() => send.apply(this, data));
  };

  const { fetch } = window;
  window.fetch = async (...request) => {
    const answer = await fetch(...request);
    await new Promise((done) => setTimeout(done, wait()));
    return answer;
  };

  const frame = window.requestAnimationFrame.bind(window);
  const cancelFrame = window.cancelAnimationFrame.bind(window);
  const given = new Map();
  const redraw = newQueue(REDRAW);
  let count = 0;
  window.requestAnimationFrame = (draw) => {
    const id = --count; // the browser's own numbers are positive
    given.set(id, draw);
    redraw(() =>
      frame((time) => {
        const mine = given.get(id);
        given.delete(id);
        mine?.(time);
      }),
    );
    return id;
  };
  window.cancelAnimationFrame = (id) => given.delete(id) || cancelFrame(id);
};
