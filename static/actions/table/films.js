// The other films of the same motion.

import { largeFilm } from '../../store/films.js';
import {
  chooseFilm,
  clockBy,
  enlargeFilm,
  filmMeant,
  nextFilm,
  placeMessage,
  signed,
  whyNoFilm,
  whyNotAddFilm,
  whyNotPlace,
} from '../films.js';

/** @typedef {import('./action.js').Action} Action */

/** @satisfies {Record<string, Action>} */
export const FILMS = {
  addFilm: {
    label: 'Add a film…',
    icon: 'film',
    also: 'second camera view multi-view multiview multiple angle video sync synchronise another',
    title: 'Another film of the same motion. When it was taken and where its camera stands are found',
    off: whyNotAddFilm,
    run: chooseFilm,
  },
  filmEarlier: {
    label: 'Film begins one frame earlier',
    icon: 'sb',
    also: 'sync offset clock second camera',
    title: 'Begin one frame earlier. With Shift a tenth of a frame',
    keys: ['Ctrl ,'],
    row: 'Move the clock of the other film',
    repeats: true,
    off: whyNoFilm,
    message: (film) => clockBy(-1, film),
  },
  filmLater: {
    label: 'Film begins one frame later',
    icon: 'sf',
    also: 'sync offset clock second camera',
    title: 'Begin one frame later. With Shift a tenth of a frame',
    keys: ['Ctrl .'],
    row: 'Move the clock of the other film',
    repeats: true,
    off: whyNoFilm,
    message: (film) => clockBy(1, film),
  },
  filmBegins: {
    label: (about) => `Begin at ${signed(about?.at ?? filmMeant()?.also[0] ?? 0)}`,
    icon: 'repeat',
    title: 'The motion repeats itself: the film may as well begin here',
    off: (about = filmMeant()) => whyNotPlace(about) || (about.also.length ? '' : 'It begins nowhere else'),
    message: (about = filmMeant()) => placeMessage(about, about?.at ?? about?.also[0] ?? 0),
  },
  placeFilm: {
    label: 'Find its camera again',
    icon: 'wand',
    also: 'second camera solve calibrate extrinsics place film',
    alone: 'Find the other film’s camera again',
    title: 'Where the film’s camera stands, found anew for the clock that it has by now',
    off: whyNotPlace,
    message: (film = filmMeant()) => placeMessage(film, film?.begins ?? 0),
  },
  enlargeFilm: {
    label: (film = filmMeant()) => (film && film === largeFilm() ? 'Shrink the film' : 'Enlarge the film'),
    icon: 'grow',
    also: 'zoom second camera view pose side by side beside',
    title: 'Side by side with the first film, to pose in both',
    keys: ['7'],
    off: whyNoFilm,
    run: (film) => (film ? enlargeFilm(film) : nextFilm()),
  },
  removeFilm: {
    label: 'Remove film',
    icon: 'trash',
    also: 'delete second camera view',
    title: 'Remove the film from this session. Its file stays',
    off: whyNoFilm,
    message: (film = filmMeant()) => ({ do: 'remove_film', view: film?.id }),
  },
};
