// The page has elements of HTML and SVG alone: both can hold the focus and data.

interface Element extends HTMLOrSVGElement {}

interface Window {
  /** For the console, and for whoever tests the page from outside. */
  keypose: object;
}
