// Everything around the work: top bar, menus, keys, guide, start screen, messages, status.

import { mountAddress } from './address.js';
import { mountBanner, mountConnection } from './banner.js';
import { mountExportDialog } from './export_dialog.js';
import { mountImportDialog } from './import_dialog.js';
import { mountFitCard } from './fit_card.js';
import { mountUpCard } from './up_card.js';
import { mountFocus } from '../controls/focus.js';
import { mountGuide } from '../guide/guide.js';
import { mountKeys, mountSheet } from './keys.js';
import { mountPeople } from '../actions/people.js';
import { mountReview } from '../actions/review.js';
import { mountMenus } from '../controls/menu.js';
import { mountSearch } from './search.js';
import { mountStatus } from './status.js';
import { mountSteady } from '../controls/layout_hold.js';
import { mountTheme } from '../actions/theme.js';
import { mountTips } from '../controls/tips.js';
import { mountToasts } from '../controls/toasts.js';
import { mountTopbar } from './topbar.js';
import { mountChooser } from '../start/chooser.js';
import { mountDropping } from '../start/uploading.js';
import { mountStart } from '../start/screen.js';

export function mount() {
  mountSteady();
  mountTheme();
  mountTopbar();
  mountStatus();
  mountStart();
  mountGuide();
  mountReview();
  mountPeople();
  mountFitCard();
  mountUpCard();
  mountSheet();
  mountSearch();
  mountChooser();
  mountExportDialog();
  mountImportDialog();
  mountToasts();
  mountConnection();
  mountAddress();
  mountBanner();
  mountTips();
  mountDropping();
  mountMenus();
  mountFocus();
  mountKeys();
}
