// What the page says, in its language. Texts are English here; docs/how-to/translate.md tells more.

const told = document.getElementById("texts");
const texts = told ? JSON.parse(told.textContent) : {};
const language = document.documentElement.lang || "en";
const plurals = new Intl.PluralRules(language);

/** A text with values for its %(name)s. */
export const _ = (text, values = {}) => filled(texts[text] ?? text, values);

/** A text about a number of things, which is its %(num)s. */
export function ngettext(one, many, num, values = {}) {
  const text = texts[one]?.[plurals.select(num)] ?? (num === 1 ? one : many);
  return filled(text, { num, ...values });
}

/** What an element holds that says a text, whose values may be elements. */
export function pieces(text, values) {
  return text.split(/(%\(\w+\)s)/).map((part) => {
    const name = /^%\((\w+)\)s$/.exec(part)?.[1];
    return name ? values[name] : part;
  });
}

/** A number as people write it, with some digits after the point. */
export function number(value, digits = 1) {
  return value.toLocaleString(language, { minimumFractionDigits: digits, maximumFractionDigits: digits });
}

/** A number with as many digits as it has. */
export const decimal = (value) => value.toLocaleString(language);

/** Several things in a row: "1, 2 and 3". */
export const listed = (words) => new Intl.ListFormat(language).format(words);

function filled(text, values) {
  return text.replace(/%\((\w+)\)s/g, (all, name) => values[name] ?? all);
}
