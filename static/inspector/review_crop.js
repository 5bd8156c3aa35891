// A small piece of a frame's picture, around a place in it.

import { server } from '../store/state.js';
import { fetchOwn } from '../store/key.js';

const SIDE = 104; // device pixels, for 52 of the page

class FrameCrop extends HTMLElement {
  shown = '';

  /** @param {{ frame: number, at: [number, number], crop: number }} spec  Pixels of the video. */
  set spec({ frame, at, crop }) {
    const version = server.camera?.image_version ?? '';
    const now = `${server.file?.path}|${version}|${frame}|${at}|${crop}`;
    if (now === this.shown) return;
    this.shown = now;
    this.load(now, `/frame/${frame}.jpg?v=${encodeURIComponent(version)}`, at, crop);
  }

  async load(asked, url, [x, y], crop) {
    const answer = await fetchOwn(url).catch(() => null);
    if (asked !== this.shown) return;
    if (!answer?.ok) {
      this.shown = ''; // asked for again when the list is drawn next
      return;
    }
    const picture = await createImageBitmap(await answer.blob());
    if (asked === this.shown) this.draw(picture, x, y, crop);
    picture.close();
  }

  draw(picture, x, y, crop) {
    // A frame may come smaller than the video is.
    const scale = picture.width / (server.camera?.width ?? picture.width);
    const canvas = Object.assign(document.createElement('canvas'), { width: SIDE, height: SIDE });
    const [left, top] = [x + 0.5 - crop / 2, y + 0.5 - crop / 2].map((at) => at * scale);
    canvas.getContext('2d')?.drawImage(picture, left, top, crop * scale, crop * scale, 0, 0, SIDE, SIDE);
    this.replaceChildren(canvas);
  }
}

customElements.define('frame-crop', FrameCrop);
