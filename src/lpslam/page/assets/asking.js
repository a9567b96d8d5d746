/* Questions and answers, kept as they come; with a server it answers, without one names are looked for. */
const log = part("log");
const asked = [];

function say(question) {
  const answer = make("div", { className: "answer", textContent: "…" }), asks = make("p", { className: "question", textContent: question });
  log.append(asks, answer);
  while (log.childElementCount > 60) log.firstElementChild.remove();
  // A long answer is read from its beginning.
  const show = () => { log.scrollTop += asks.getBoundingClientRect().top - log.getBoundingClientRect().top; };
  show();
  return (text, ...more) => {
    // Reasons and other places are indented: they are small print.
    const lines = text.split("\n").map(line => make("div", { className: line.startsWith("  ") ? "soft" : "", textContent: line.trim() }));
    answer.replaceChildren(...lines, ...more);
    show();
  };
}

/* Without a server a name is looked for in the signs' own words. */
function byName(question) {
  const wanted = fold(question).replace(/[?？!！.。]/g, " ").split(/\s+/).filter(Boolean);
  const scored = data.signs.map(sign => {
    const all = fold([sign.name, ...sign.lines, ...Object.keys(sign.variants)].join(" "));
    return [wanted.filter(word => all.includes(word)).reduce((sum, word) => sum + word.length, 0) + (all.includes(fold(question.trim())) ? 100 : 0), sign];
  }).filter(([score]) => score > 0).sort((a, b) => b[0] - a[0]);
  return scored.map(([, sign]) => sign);
}

async function post(url, body) {
  const response = await fetch(url, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });
  return [response, await response.json()];
}

async function askServer(question, tell, wish = null) {
  const body = { question, ...(wish ? { wish } : {}) };
  if (data.name) body.map = data.name;
  const last = asked[asked.length - 1];
  // “And another one?” asks the question before it again, for what was not named yet.
  if (last && !wish) Object.assign(body, { before: last.question, excluded: last.named.slice(-200), ...(last.wish ? { before_wish: last.wish } : {}) });
  const [response, found] = await post("/ask", body);
  if (!response.ok) throw new Error(found.detail || response.statusText);
  const { landmark, stops, wish: meant } = found.answer, id = landmark && landmark.id;
  const isFurther = last && !wish && found.understood === last.understood;
  asked.push({ question: isFurther ? last.question : question, wish: isFurther ? last.wish : wish, understood: found.understood, named: [...(isFurther ? last.named : []), ...(id === null ? [] : [id])] });
  // Of a plan some of whose stops nothing serves, the way leads to the others.
  const mine = asked[asked.length - 1], before = stops.filter(stop => stop !== null), to = before.pop() ?? null;
  const lead = async (text, last) => {
    const steps = await leadTo([...before, last], meant.language);
    if (steps) tell(`${text}\n${steps}`, understood);
  };
  const understood = understoodOf(found, changed => answerTo(question, tell, changed), sign => {
    pick(sign);
    mine.named.push(sign.id);
    tell(sign.name, understood);
    lead(sign.name, sign.id);
  });
  tell(found.text, understood);
  choose(data.signs.find(sign => sign.id === to) || null);
  if (to !== null) await lead(found.text, to);
}

async function answerTo(question, tell, wish = null) {
  dropWay();
  try { await askServer(question, tell, wish); } catch (error) { tell(`${words.trouble} ${error.message}`); }
}

part("ask").addEventListener("submit", async event => {
  event.preventDefault();
  const question = field.value.slice(0, 400).trim();
  if (!question) return;
  dropWay();
  const tell = say(question);
  field.select();
  if (!data.live) {
    const found = byName(question);
    tell(found.length ? found[0].name : words.nothing);
    choose(found[0] || null);
    return;
  }
  await answerTo(question, tell);
});
