// The page's rooms, put together.

import { connect } from './store/link.js';
import { server, ui, watch } from './store/state.js';
import { mountMemory } from './store/storage.js';
import { mount as mountViews, view } from './views/views.js';
import { mount as mountHandles } from './handles/handles.js';
import { mount as mountInspector } from './inspector/inspector.js';
import { mount as mountTimeline } from './timeline/timeline.js';
import { mount as mountChrome } from './shell/chrome.js';

mountMemory();
mountViews();
mountHandles();
mountInspector();
mountTimeline();
mountChrome();
connect();

// For the console, and for whoever tests the page from outside.
const module = (path) => import(new URL(path, import.meta.url).href);
window.keypose = { server, ui, view, module };
watch(['file'], () => {
  if ('file' in server) document.documentElement.dataset.ready = 'yes';
});
