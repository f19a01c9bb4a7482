// Theme, folded parts and printing; what plots.js and viewer.js share.
"use strict";
const opaline = (() => {
  const themes = ["as the system", "dark", "light"];
  const root = document.documentElement;
  const button = document.getElementById("theme");
  const system = matchMedia("(prefers-color-scheme: dark)");
  let printing = false;

  // Files opened from disk may have no storage.
  const stored = () => { try { return localStorage.getItem("opaline-theme"); } catch { return null; } };
  const store = (theme) => { try { localStorage.setItem("opaline-theme", theme); } catch { /* not kept */ } };

  const changed = () => document.dispatchEvent(new Event("opaline-theme"));
  const apply = (theme) => {
    if (theme === themes[0]) delete root.dataset.theme;
    else root.dataset.theme = theme;
    button.textContent = `Theme: ${theme}`;
    changed();
  };
  let theme = themes.includes(stored()) ? stored() : themes[0];
  button.addEventListener("click", () => {
    theme = themes[(themes.indexOf(theme) + 1) % themes.length];
    store(theme);
    apply(theme);
  });
  system.addEventListener("change", changed);
  apply(theme);

  // A link into a folded table opens it.
  const reveal = () => {
    const target = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target) return;
    for (let e = target.parentElement; e; e = e.parentElement) if (e.tagName === "DETAILS") e.open = true;
    target.scrollIntoView({ block: "center", inline: "start" });
  };
  addEventListener("hashchange", reveal);
  addEventListener("load", reveal);
  // A second click on the same link does not change the address.
  document.addEventListener("click", (event) => {
    const link = event.target.closest("a[href^='#']");
    if (link && link.hash === location.hash) reveal();
  });

  // On paper folded tables are open, but for the longest.
  const longest = 60;
  let opened = [];
  addEventListener("beforeprint", () => {
    printing = true;
    opened = [...document.querySelectorAll("details:not([open])")].filter((d) => d.querySelectorAll("tr").length <= longest);
    for (const d of opened) d.open = true;
    changed();
  });
  addEventListener("afterprint", () => {
    printing = false;
    for (const d of opened) d.open = false;
    changed();
  });

  const element = (name, properties = {}, children = []) => {
    const e = Object.assign(document.createElement(name), properties);
    e.append(...children);
    return e;
  };
  const select = (label, names, onchange, id) => {
    const list = element("select", { onchange, id }, names.map((name, value) => element("option", { value, textContent: name })));
    return { list, label: element("label", {}, [label + " ", list]) };
  };
  return {
    dark: () => !printing && (root.dataset.theme ? root.dataset.theme === "dark" : system.matches),
    printing: () => printing,
    json: (id) => JSON.parse(document.getElementById(id).textContent),
    element, select,
  };
})();
