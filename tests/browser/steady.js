// What a test does in the page, all at once: feed it with news as the server would, press, look.
async () => {
  const state = await window.keypose.module('store/state.js');
  const { toast } = await window.keypose.module('controls/toasts.js');
  const { isReady } = await window.keypose.module('handles/targets.js');
  const CONTROLS = 'button, input, [role=slider], [role=option], number-field';
  const EDGE = 8; // the lines between the views, which are dragged

  Element.prototype.setPointerCapture = () => {}; // which these pointers cannot have
  const drawn = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));

  const feed = async ({ sections, ui, toasts, theme }) => {
    document.documentElement.dataset.theme = theme;
    for (const [name, value] of Object.entries(ui)) state.setUi(name, value);
    toasts.forEach(toast);
    state.applySections(sections);
    await drawn();
    await drawn(); // what gives way to what was drawn
  };

  const point = (kind, target, [clientX, clientY], buttons) =>
    target.dispatchEvent(new PointerEvent(kind, {
      clientX, clientY, buttons,
      pointerType: 'mouse', isPrimary: true, bubbles: true, cancelable: true,
    }));

  const boxOf = (element) => JSON.stringify(element.getBoundingClientRect());
  const said = (element) => element.outerHTML.replace(/<!--.*?-->/g, '').slice(0, 160);

  /** The middles of all controls that could be pressed now. */
  const spots = () => [...document.querySelectorAll(CONTROLS)].flatMap((element) => {
    const { left, top, width, height } = element.getBoundingClientRect();
    const [x, y] = [left + width / 2, top + height / 2];
    const hit = document.elementFromPoint(x, y);
    return width && hit && element.contains(hit) ? [[x, y]] : [];
  });

  /**
   * What takes the press of a handle that is drawn. A control that is pressed may have changed the pose,
   * and the server's answer is known before it is drawn, with the holes for it.
   */
  const covered = () => ['main', 'top', 'side', 'front', 'free'].map(window.keypose.view).filter(isReady).flatMap((view) => {
    const { left, top, right, bottom } = view.over.getBoundingClientRect();
    return [...view.over.querySelectorAll('[data-grip]')].flatMap((grip) => {
      const box = grip.getBoundingClientRect();
      const [x, y] = [box.left + box.width / 2, box.top + box.height / 2];
      if (x < left + EDGE || x > right - EDGE || y < top + EDGE || y > bottom - EDGE) return [];
      const hit = document.elementFromPoint(x, y);
      return !hit || view.over.contains(hit) ? [] : [`${grip.dataset.grip} of ${view.name} lies under ${said(hit)}`];
    });
  });

  /** Press a control, let the news come, and say what became of it. */
  const press = async (news, share) => {
    const all = spots();
    const at = all[Math.floor(share * all.length)];
    const found = document.elementFromPoint(...at);
    const control = found.closest(CONTROLS) ?? found;
    point('pointermove', found, at, 0);
    point('pointerdown', found, at, 1);
    const box = boxOf(control);
    await feed(news);
    const now = document.elementFromPoint(...at);
    const problem = !control.contains(now)
      ? [`${said(control)} became ${said(now)}`]
      : box === boxOf(control) ? [] : [`${said(control)} moved from ${box} to ${boxOf(control)}`];
    point('pointerup', found, at, 0);
    await drawn(); // what has waited for the release
    return problem;
  };

  window.steady = {
    feed,
    /** Problems of all cases: what was covered, what moved. */
    async run(cases) {
      const problems = [];
      for (const [number, { before, after, share }] of cases.entries()) {
        await feed(before);
        const found = [...covered(), ...(await press(after, share)), ...covered()];
        problems.push(...found.map((problem) => `state ${number}: ${problem}`));
      }
      return problems;
    },
  };
}
