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

function listen() {
  const hearing = new Hearing();
  Object.assign(hearing, { lang: spoken, processLocally: true, interimResults: false, maxAlternatives: 1 });
  hearing.onresult = event => {
    field.value = event.results[0][0].transcript.slice(0, 400);
    part("ask").requestSubmit();
  };
  hearing.onend = () => mouth.setAttribute("aria-pressed", "false");
  mouth.setAttribute("aria-pressed", "true");
  hearing.start();
}

mouth.addEventListener("click", listen);
offerSpeech();
