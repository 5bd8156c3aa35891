// What cannot be said of nodes through viser: what is drawn for its depth alone, and how faint
// lines are. Applied before every picture, since viser may have made a node anew.
//
// Over the film the body is one translucent sheet: its opaque solids are drawn first, without
// colour, so that of everything else only what lies in front is seen.
//
// In the small views an observed surface is such a sheet too, after the body that stands in it: its
// nearest layer is drawn without colour, and then that layer alone with its colours.

const FIRST = -1;
const [BEHIND_SHEET, SHEET] = [1, 2];

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
    surface: {
      depth: { order: BEHIND_SHEET, transparent: true, colorWrite: false, depthWrite: true },
      sheet: { order: SHEET, transparent: true, opacity: 0.42, depthWrite: false },
    },
  },
};

/** Apply the looks to the nodes of one view; `nodes` are three.js objects by name. */
export function applyLooks(role, nodes) {
  const looks = LOOKS[role] ?? LOOKS.small;
  for (const name in nodes) {
    const words = name.split('/');
    const look = looks[words.at(-1)] ?? looks[words.at(-2)] ?? looks[words.at(-3)];
    if (look) nodes[name]?.traverse((object) => applyLook(object, look));
  }
}

/** A look may differ by the name of what an object is made of. */
function applyLook(object, look) {
  if (!object.material) return;
  const { order = 0, ...values } = look[object.material.name] ?? look;
  object.renderOrder = order;
  for (const [key, value] of Object.entries(values)) {
    if (object.material[key] !== value) object.material[key] = value;
  }
}
