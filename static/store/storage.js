// What a browser keeps for this page: over visits, or for one tab over a reload. A browser that keeps
// nothing, or has no room left, has it at least as long as the page is.

/** @param {() => Storage} place */
function storage(place) {
  const unkept = new Map();
  const attempt = (act) => {
    try {
      return act(place());
    } catch {
      return undefined; // keeping was forbidden, or there is no room
    }
  };
  return {
    /** What was kept under this name, or null. */
    read: (name) => unkept.get(name) ?? attempt((kept) => kept.getItem(name)) ?? null,
    write(name, value) {
      const isKept = attempt((kept) => {
        kept.setItem(name, String(value));
        return true;
      });
      if (isKept) unkept.delete(name);
      else unkept.set(name, String(value));
    },
    remove(name) {
      unkept.delete(name);
      attempt((kept) => kept.removeItem(name));
    },
  };
}

/** Over visits, for every tab of this page's origin. */
export const inBrowser = storage(() => localStorage);

/** Over a reload, for this tab alone. */
export const inTab = storage(() => sessionStorage);
