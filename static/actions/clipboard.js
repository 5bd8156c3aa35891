// The browser's clipboard: text goes there and comes from there where that is allowed.

/** Put a text there that is still on its way; whether it could be. @param {Promise<string>} text */
export async function writeText(text) {
  try {
    if (window.ClipboardItem && navigator.clipboard?.write) {
      // Given as a promise, so that the key that was pressed still counts when it comes.
      const blob = text.then((known) => new Blob([known], { type: 'text/plain' }));
      blob.catch(() => {}); // reported by the clipboard, too
      await navigator.clipboard.write([new ClipboardItem({ 'text/plain': blob })]);
    } else {
      await navigator.clipboard.writeText(await text);
    }
    return true;
  } catch {
    return false;
  }
}

/** What is there; null where it cannot be read. */
export async function readText() {
  try {
    return await navigator.clipboard.readText();
  } catch {
    return null;
  }
}
