// Elements that are there for as long as the page is.

/**
 * Make an element over everything else, where sheets, menus and messages are drawn.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {string} id
 * @param {Tag} tag
 */
export function addOnTop(id, tag) {
  const place = document.getElementById('screens');
  if (!place) throw new Error('The page has no #screens');
  const element = document.createElement(tag);
  element.id = id;
  place.append(element);
  return element;
}
