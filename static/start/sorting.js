// The order of the files in a list, and how many lie in a folder.

const BY = {
  name: (one, other) => one.name.localeCompare(other.name, undefined, { numeric: true, sensitivity: 'base' }),
  size: (one, other) => one.bytes - other.bytes,
  date: (one, other) => one.modified_at - other.modified_at,
};

/**
 * Files by name, size or date; equal ones by name.
 * @template {{ name: string, bytes: number, modified_at: number }} File
 * @param {File[]} files
 * @param {{ by: 'name' | 'size' | 'date', down: boolean }} [order]
 * @returns {File[]}
 */
export function sorted(files, { by, down } = { by: 'name', down: false }) {
  const way = down ? -1 : 1;
  return [...files].sort((one, other) => way * BY[by](one, other) || BY.name(one, other));
}

/**
 * How many of these files lie in a folder or in those inside it.
 * @param {string} folder  Its id.
 * @param {{ id: string }[]} files
 */
export function heldIn(folder, files) {
  const inside = folder.endsWith('/') ? folder : `${folder}/`;
  return files.filter(({ id }) => id.startsWith(inside)).length;
}
