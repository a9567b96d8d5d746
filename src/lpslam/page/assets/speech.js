/* Asking aloud, where the browser hears on this machine itself: what is said must not leave it either. */
const Hearing = window.SpeechRecognition || window.webkitSpeechRecognition;
const mouth = part("speak");
const spoken = navigator.language || "en";

async function offerSpeech() {
  if (!Hearing || typeof Hearing.available !== "function") return;
  try {
    if (await Hearing.available({ langs: [spoken], processLocally: true }) !== "available") return;
  } catch {
    return;
  }
  mouth.textContent = "🎤";
  mouth.title = words.speak;
  mouth.setAttribute("aria-label", words.speak);
  mouth.hidden = false;
}

let heard = null;

/* Asked once more while it listens, it stops. */
function listen() {
  if (heard) return heard.abort();
  const hearing = heard = new Hearing();
  Object.assign(hearing, { lang: spoken, processLocally: true, interimResults: false, maxAlternatives: 1 });
  hearing.onresult = event => {
    field.value = event.results[0][0].transcript.slice(0, 400);
    part("ask").requestSubmit();
  };
  hearing.onerror = event => { if (event.error !== "aborted") complain(`${words.unheard} (${event.error})`); };
  hearing.onend = () => {
    heard = null;
    mouth.setAttribute("aria-pressed", "false");
  };
  complain("");
  mouth.setAttribute("aria-pressed", "true");
  hearing.start();
}

mouth.addEventListener("click", listen);
offerSpeech();
