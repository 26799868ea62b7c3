// A text from anywhere, such as an error's, as a sentence that a person reads on the page.

/** The text with a capital and a full stop; nothing stays nothing. */
export function sentence(text) {
  const end = /[.!?]$/.test(text) ? "" : ".";
  return text === "" ? "" : text[0].toUpperCase() + text.slice(1) + end;
}
