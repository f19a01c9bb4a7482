// Two images under one slider, and the error of the right one.
"use strict";
(() => {
  const viewer = document.getElementById("viewer");
  if (!viewer) return;
  const part = (name) => document.getElementById(`viewer-${name}`);
  const [scene, left, right, beside, stage, slider] = ["scene", "left", "right", "beside", "stage", "slider"].map(part);
  const scenes = new Map();  // parsed when first shown
  const gallery = () => {
    if (!scenes.has(scene.value)) scenes.set(scene.value, opaline.json(`gallery-${scene.value}`));
    return scenes.get(scene.value);
  };

  const fill = (list, chosen) => {
    const groups = new Map();
    gallery().entries.forEach((entry, value) => {
      if (!groups.has(entry.kind)) groups.set(entry.kind, opaline.element("optgroup", { label: entry.kind }));
      groups.get(entry.kind).append(opaline.element("option", { value, textContent: entry.label }));
    });
    list.replaceChildren(...groups.values());
    list.value = chosen;
  };
  const title = (entry) => entry.kind === "image" ? entry.label : `${entry.kind} of ${entry.label}`;
  const put = (image, key, alt) => {
    image.hidden = !key;
    if (key) image.src = gallery().images[key];
    image.alt = alt;
  };

  const show = () => {
    const a = gallery().entries[left.value], b = gallery().entries[right.value];
    put(part("image-left"), a.image, `${title(a)}: ${a.note}`);
    put(part("image-right"), b.image, `${title(b)}: ${b.note}`);
    part("caption").textContent = `Left: ${title(a)} (${a.note}). Right: ${title(b)} (${b.note}).`;
    put(part("error"), b.error, `Error of ${title(b)}, false colours`);
    part("error-caption").textContent = b.error ? `Error of ${title(b)} against the reference, on the scale below.` : `${title(b)} has no error image: it is ${b.kind === "image" ? "the reference itself, or has none" : "shown on the scale below itself"}.`;
  };
  const place = () => {
    part("image-left").style.clipPath = `inset(0 ${100 - slider.value}% 0 0)`;
    part("handle").style.left = `${slider.value}%`;
    slider.setAttribute("aria-valuetext", `${slider.value} percent left image`);
  };
  const choose = () => { fill(left, gallery().left); fill(right, gallery().right); show(); };

  scene.addEventListener("change", choose);
  left.addEventListener("change", show);
  right.addEventListener("change", show);
  slider.addEventListener("input", place);
  beside.addEventListener("change", () => viewer.classList.toggle("beside", beside.checked));
  const drag = (event) => {
    if (event.buttons !== 1 || beside.checked) return;
    const box = stage.getBoundingClientRect();
    slider.value = Math.round(100 * Math.min(1, Math.max(0, (event.clientX - box.left) / box.width)));
    place();
  };
  stage.addEventListener("pointerdown", drag);
  stage.addEventListener("pointermove", drag);

  // Decoding many images must not delay the page: the first ones come when the viewer is near the window.
  const start = () => { watcher.disconnect(); choose(); place(); };
  const watcher = new IntersectionObserver((entries) => { if (entries.some((e) => e.isIntersecting)) start(); }, { rootMargin: "600px" });
  watcher.observe(viewer);
  addEventListener("beforeprint", () => { if (!left.options.length) start(); });
})();
