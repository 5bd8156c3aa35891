// Whether this browser's 3D is software, and so slow that the page paints the body by itself.

const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** What draws the browser's 3D, by name; nothing where it draws none. @returns {string | null} */
function renderer() {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return null;
  const known = gl.getExtension('WEBGL_debug_renderer_info');
  const name = String(gl.getParameter(known ? known.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return name;
}

/** @param {string | null} name  What draws 3D. */
export const isSoftware = (name) => name !== null && SOFTWARE.test(name);

/** @type {string | null | undefined} */
let known;

/** @returns {'none' | 'software' | 'hardware'} */
export function drawsBy() {
  known = known === undefined ? renderer() : known;
  if (known === null) return 'none';
  return isSoftware(known) ? 'software' : 'hardware';
}
