"use strict";
// Advice names the command line's options. On the page each has its place: a field of the dialogue, the choice below a column's name, a range of a record.

// The fields of the dialogue beside the columns, each called as its option or as its key of the motor file.
const FIELDS = [...document.querySelectorAll("#mapping [data-field]")];
const isRare = (field) => Boolean(field.closest("#log-more"));
const labelOf = (field) => field.closest("label").firstChild.textContent.trim();
// Whether a text of the page names a field that is folded away.
const namesRare = (text) => FIELDS.some((field) => isRare(field) && text.includes(`"${labelOf(field)}"`));
// The field that a name in advice means, if one does.
const fieldOf = (name) => FIELDS.find((field) => field.name === name.replaceAll("-", "_"));
// A value as a person sees it in its field.
const shownIn = (field, value) => (field.options ? `"${[...field.options].find((o) => o.value === value)?.textContent ?? value}"` : value);
// What stands in the fields, by their names.
const rigChosen = () => Object.fromEntries(FIELDS.map((field) => [field.name, field.value.trim()]).filter(([, value]) => value));

const kindWords = (kind) => (!kind ? "not used" : kind.endsWith("-:") ? `taken off the ${kind.slice(0, -2)}: the bridge's other side` : kind.replace(":", kind.startsWith("duty") ? " of " : " in ").replace("time+", "fraction of the time"));
const QUANTITIES = "time|interval|voltage|duty|direction|target|angle|speed|current|supply";
// A part of a mapping, "duty=pwm:255", as what is chosen below the names: "pwm" as duty of 255.
function chosenAs(quantity, column, unit, names) {
  const called = (one) => (/^(COLUMN|SUPPLY|\.\.\.)/.test(one) ? "its column" : `"${names.includes(one) ? one : names[Number(one)] ?? one}"`);
  const [one, other] = names.includes(column) || !names.length ? [column] : column.split("-");
  const kind = unit ? kindWords(`${quantity}:${unit}`) : quantity === "direction" ? kindWords("direction:sign") : quantity;
  return `${called(one)} as ${kind}` + (other ? ` and ${called(other)} as ${kindWords(quantity + "-:")}` : "");
}
// The rows of one motor, "only=id:3", have a field, which `called` names.
function partAs(part, names, called) {
  const [, quantity, said] = part.trim().match(/^(\w+)=(.*)$/) || [], end = said ? said.lastIndexOf(":") : -1;
  if (quantity === "only") return `${said} in ${called(fieldOf("only"))}`;
  return quantity && new RegExp(`^(${QUANTITIES})$`).test(quantity) ? chosenAs(quantity, end < 0 ? said : said.slice(0, end), end < 0 ? "" : said.slice(end + 1), names) : part.trim();
}
// Ranges that are left out, "--skip run:3.2..4.0 --skip run:5..6".
function skippedAs(options) {
  const ranges = [...options.matchAll(/--skip ("[^"]*"|[^\s,;)]+)/g)].map(([, range]) => range.replaceAll('"', "")), name = ranges[0].slice(0, Math.max(ranges[0].lastIndexOf(":"), 0));
  return `under 1 Compare (Brush out, or From and To: ${listed(ranges.map((range) => range.slice(range.lastIndexOf(":") + 1).replace("..", " to ") + " s"))}${name && ` of ${name}`})`;
}

// The advice `text` in the words of the page. Columns that it calls by their numbers have these `names`; in the dialogue nothing has to be opened first.
function advised(text, names, inDialogue) {
  const again = state && state.data.entries.some((e) => e.file !== null);
  let placed = inDialogue, unfolded = false;
  const choose = () => {
    const before = placed ? "" : again ? 'press "columns" beside the record and ' : "open the log again and ";
    placed = true;
    return before + "choose ";
  };
  // A field is named by its label, the first time with the way to it.
  const called = (field) => {
    const way = [placed ? "" : again ? '"columns" beside the record' : "where the log is opened", isRare(field) && !unfolded ? 'under "More"' : ""].filter(Boolean);
    placed = true;
    unfolded ||= isRare(field);
    return `"${labelOf(field)}"` + (way.length ? ` (${way.join(", ")})` : "");
  };
  const columns = (all, verb, map) => {
    const [, end] = map.match(/((?:,\.\.\.)?[);,]*)$/), parts = map.slice(0, map.length - end.length).replaceAll('"', "").replace(/^\.\.\.,/, "").split(",");
    return (!verb || /say|write/.test(verb) ? choose() : `${verb} `) + parts.map((part) => partAs(part, names, called)).join(", ") + end.replace(",...", ", ...");
  };
  // A figure that goes with chosen columns follows them: "..., with 12 in its field".
  const figures = (all, blank, option, value, at, whole) => {
    const field = fieldOf(option), own = value && !/^[A-Z]/.test(value), before = whole.slice(0, at);
    // Another program has options too.
    if (!field || /\.py$/.test(before)) return all;
    const follows = /(?: as [a-z ]+ (?:in|of) \S+|other side|--[a-z-]+ [\d.]+)$/.test(before);
    if (follows && value) return `, with ${own ? shownIn(field, value) : "your figure"} in ${called(field)}`;
    return blank + (own ? `${shownIn(field, value)} in ` : "") + called(field);
  };
  const keys = (all, verb, list) => {
    const known = list.split(" and ").map(fieldOf);
    return known.every(Boolean) ? `${verb === "give" ? "fill in" : verb} ${listed(known.map(called))}` : all;
  };
  return text.replace(/turn the column round with --map ("[^"]*"|\S+)/, `open the log again and tick "${$("log-turned").parentElement.textContent.trim()}"`)
    .replace("--skip and --judge-by take the records by their names", "each of them has its role in the table above")
    .replace(/ \(--skip( FROM\.\.TO)?\)/, " (Brush out)").replace(" (motorlens serve LOG...)", " (1 Compare)").replace(" (fit --method feedforward)", "")
    .replace(/(?:with )?--skip (?:"[^"]*"|[^\s,;)]+)(?: --skip (?:"[^"]*"|[^\s,;)]+))*/g, skippedAs)
    .replace(/motorlens fit LOG\.\.\. -e ([\w,]+)/, (_, effects) => `have ${listed(effects.split(","))} and nothing else in the model (4 Add)`)
    .replace(/fit --effects ([\w,]+)/, (_, effects) => `4 Add: ${effects === "none" ? "no effect" : listed(effects.split(",")) + " and nothing else"}`)
    .replace(/^(?:say|add|give the voltage of the supply, for example) --([a-z-]+) ([\d.]+)/, (all, option, value) => (fieldOf(option) ? `fill in ${called(fieldOf(option))}, such as ${value}` : all))
    .replace(/,? (?:or )?put \w+ into motor\.toml/, "").replace(/\b(give|correct) (\w+(?: and \w+)*)(?: in motor\.toml)?/g, keys)
    .replace(/(?:\b(say|write|with|as|or|is) )?--map ("[^"]*=[^"]*"|[^\s"]*=\S*)/g, columns)
    .replace(new RegExp(`(?:\\b(say|write) )?\\b(${QUANTITIES})=([^=,;:"]+):([^\\s,;)"]+)`, "g"), (_, verb, quantity, column, unit) => (verb ? choose() : "") + chosenAs(quantity, column, unit, names))
    .replace(/\bdirection=COLUMN\b/g, chosenAs("direction", "COLUMN", "", names))
    .replace(/\b(with|to) --map\b/g, inDialogue ? "in the row below the names" : 'under "columns" beside the record')
    .replace(/\bwith (--[a-z-]+)(?! [\da-z])/g, (all, option) => (fieldOf(option.slice(2)) ? `in ${option}` : all))
    .replace(/( ?)--([a-z][a-z-]*[a-z])(?: (\d+(?:\.\d+)?|zero|first|[A-Z][A-Z_]*\b))?/g, figures);
}
function onPage(text) {
  if (/^say which column(?! holds)|^choose the columns/.test(text)) return "say in the row below the names what each column is: the time, the voltage (or duty), and the angle or the speed; each once";
  const inDialogue = $("dialog").open;
  return advised(text, inDialogue ? dropped.table.names : [], inDialogue);
}
// What is told of a log needs no way to the fields that it names.
const toldOnPage = (text) => advised(text, $("dialog").open ? dropped.table.names : [], true);
// A question of the guess, or advice, as a sentence of the dialogue.
function askedOnPage(question, names) {
  const said = advised(question, names, true);
  return said[0].toUpperCase() + said.slice(1) + ".";
}
