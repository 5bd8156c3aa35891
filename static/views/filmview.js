// The view of another film, beside the large one: its picture, and the body over it as its camera sees it.

import { largeFilm } from '../store/films.js';
import { watch } from '../store/state.js';
import { filmEye } from './cameras.js';
import { GREATEST_SCALE, place } from './cameraview.js';
import { FilmPicture } from './film_picture.js';
import { View } from './view.js';

/** What the bars above and below the picture take, px. */
const ROOM = { x: 0, top: 44, bottom: 44 };

export class FilmView extends View {
  /** Called when it is known why there is no picture, or again one. */
  told = () => {};

  #picture = new FilmPicture(() => this.#pictureChanged(), this.window);
  #id = '';

  constructor(el) {
    super(el);
    el.classList.add('painted');
    el.prepend(this.#picture.picture);
    this.over.before(this.#picture.figure);
    watch(['films', 'solids', 'body', 'view', 'u:filmLarge', 'u:filmHeld', 'u:sight'], () => this.follow());
  }

  #pictureChanged() {
    this.redraw();
    this.told();
  }

  get isShown() {
    return largeFilm() !== null;
  }

  get isInLargePlace() {
    return true;
  }

  /** The page paints the body in it: viser draws the four views of the first film. */
  get isPainted() {
    return true;
  }

  /** Nothing can be grabbed where the film shows nothing. */
  get isEmpty() {
    return largeFilm()?.frame === null;
  }

  /** Why there is no picture, a sentence. */
  get why() {
    return this.#picture.why;
  }

  inMessage() {
    return { view: 'film', film: largeFilm().id };
  }

  newEye() {
    this.follow();
  }

  /** Show what the film shows now. */
  follow() {
    const film = largeFilm();
    const id = film?.id ?? '';
    if (id !== this.#id) this.window.chosen = false;
    this.#id = id;
    this.eye = film && filmEye(film.camera, film.T);
    if (!film) return this.#picture.rest();
    this.fitToSize();
    this.#picture.follow(film);
    return undefined;
  }

  showAll() {
    const film = largeFilm();
    if (!film) return;
    const { width, height } = film.camera;
    this.window.showBox([-0.5, -0.5, width - 0.5, height - 0.5], ROOM);
    this.window.limit(Math.min(0.1, this.window.scale / 2), GREATEST_SCALE);
  }

  draw() {
    super.draw();
    const film = largeFilm();
    if (!film) return;
    this.#picture.paint();
    place(this.#picture.picture, film.camera, this.window);
  }
}
