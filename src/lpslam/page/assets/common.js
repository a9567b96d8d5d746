/* What all parts share: the map's data, the words of the visitor's language, and elements whose content is only ever text. */
const data = JSON.parse(document.getElementById("map-data").textContent);
const words = data.words[(navigator.language || "en").slice(0, 2)] || data.words.en;
const part = id => document.getElementById(id);
const canvas = part("map"), pen = canvas.getContext("2d");
const state = { chosen: null, way: [], legs: [], stops: [], isGroundless: false, camera: null, isSpatial: false, isFirstPerson: false };

/* Colours of the style, looked up once as long as it is light or dark. */
const colours = new Map();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => colours.clear());

function style(name) {
  if (!colours.has(name)) colours.set(name, getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  return colours.get(name);
}

const fold = text => text.normalize("NFKD").replace(/\p{M}/gu, "").toLowerCase();
const filled = (text, values) => text.replace(/\{(\w+)\}/g, (_, key) => String(values[key]));

const clamped = (value, least, most) => Math.min(Math.max(value, least), most);

function make(tag, properties = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

/* A part of the map that the server gives when it is wanted; null where it does not. */
const givenLater = (name, kind) => askedOf(`page/${encodeURIComponent(data.name)}/${name}`, kind);

async function askedOf(path, kind) {
  try {
    const response = await fetch(`/${path}`);
    return response.ok ? await response[kind]() : null;
  } catch {
    return null;
  }
}
