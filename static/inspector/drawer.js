// In a narrow window the inspector is a drawer over the views; a tag on its edge pulls it out.

import { html, render } from '../vendor/lit-html/lit-html.js';
import { icon } from '../controls/icons.js';

/** Put the tag on the inspector's left edge; the style sheet shows it where it is needed. */
export function addDrawer(inspector) {
  const place = document.createElement('div');
  place.className = 'insp-tag';
  inspector.append(place);
  const draw = () => {
    const open = inspector.classList.contains('open');
    const label = open ? 'Close the inspector' : 'Open the inspector';
    const toggle = () => {
      inspector.classList.toggle('open');
      draw();
    };
    render(
      html`<button type="button" aria-label=${label} title=${label} aria-expanded=${open} @click=${toggle}>
        ${icon(open ? 'sf' : 'sb')}
      </button>`,
      place,
    );
  };
  draw();
}
