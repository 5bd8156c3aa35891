// Many calls, one per animation frame: the newest wins, and `flush` makes it happen now.

export function paced(act) {
  let waiting = null;
  let asked = false;
  const flush = () => {
    if (waiting === null) return;
    const args = waiting;
    waiting = null;
    act(...args);
  };
  const call = (...args) => {
    waiting = args;
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      flush();
    });
  };
  return Object.assign(call, { flush });
}
