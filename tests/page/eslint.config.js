// How the page's JavaScript is to be written; `make check` runs it.

import js from '@eslint/js';
import globals from 'globals';

/** The rooms of the page: each imports only those before it. */
const ROOMS = ['store', 'controls', 'views', 'actions', 'handles', 'timeline', 'inspector', 'guide', 'start', 'shell'];

const above = ROOMS.slice(0, -1).map((room, i) => ({
  files: [`static/${room}/**/*.js`],
  rules: {
    'no-restricted-imports': [
      'error',
      { patterns: [{ regex: `^(\\.\\./)+(${ROOMS.slice(i + 1).join('|')})/`, message: 'Knowledge flows one way.' }] },
    ],
  },
}));

export default [
  { ignores: ['**/vendor/**', '**/node_modules/**'] },
  js.configs.recommended,
  {
    linterOptions: { reportUnusedDisableDirectives: 'error' },
    rules: {
      curly: ['error', 'multi-line'],
      eqeqeq: ['error', 'always', { null: 'ignore' }],
      'no-duplicate-imports': 'error',
      'no-else-return': 'error',
      'no-implicit-globals': 'error',
      'no-self-compare': 'off', // value === value is how a number that is NaN is told apart
      'no-shadow': 'error',
      'no-unused-expressions': ['error', { allowShortCircuit: true, allowTernary: true }],
      'no-unused-vars': ['error', { args: 'after-used', caughtErrors: 'all' }],
      'no-use-before-define': ['error', { functions: false, variables: false }],
      'no-useless-assignment': 'error',
      'no-var': 'error',
      'object-shorthand': 'error',
      'prefer-const': 'error',
    },
  },
  ...above,
  { files: ['static/**/*.js'], languageOptions: { globals: globals.browser } },
  { files: ['tests/page/**/*.js'], languageOptions: { globals: globals.node } },
];
