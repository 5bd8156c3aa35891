// What the page uses of lit-html, for the type check: the vendored file is minified.

export interface TemplateResult {
  strings: TemplateStringsArray;
  values: unknown[];
}

export function html(strings: TemplateStringsArray, ...values: unknown[]): TemplateResult;
export function svg(strings: TemplateStringsArray, ...values: unknown[]): TemplateResult;

/** A template that draws nothing. */
export const nothing: TemplateResult;

export function render(value: unknown, place: Element | DocumentFragment): void;
