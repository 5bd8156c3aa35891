// What viser cannot be told about its nodes: what is drawn for its depth alone, and how faint
// lines are. Applied before every picture, since viser may have made a node anew.
//
// Over the film the body is one translucent sheet: its opaque solids are drawn first, without
// colour, so that of everything else only what lies in front is seen.

const FIRST = -1;

/** By view and by the kind of node, which is one of the last three words of its name. */
const LOOKS = {
  main: {
    solid: { order: FIRST, colorWrite: false },
    wires: { transparent: true, opacity: 0.38, depthWrite: false },
    ghost: { transparent: true, opacity: 0.75, depthWrite: false },
    trail: { depthTest: false, transparent: true, depthWrite: false },
  },
  small: {
    ghost: { transparent: true, opacity: 0.6, depthWrite: false },
    trail: { depthTest: false, transparent: true, depthWrite: false },
  },
};

/** Dress the nodes of one view; `nodes` are three.js objects by name. */
export function dress(role, nodes) {
  const looks = LOOKS[role] ?? LOOKS.small;
  for (const name in nodes) {
    const words = name.split('/');
    const look = looks[words.at(-1)] ?? looks[words.at(-2)] ?? looks[words.at(-3)];
    if (look) nodes[name]?.traverse((object) => wear(object, look));
  }
}

function wear(object, { order = 0, ...values }) {
  if (!object.material) return;
  object.renderOrder = order;
  for (const [key, value] of Object.entries(values)) {
    if (object.material[key] !== value) object.material[key] = value;
  }
}
