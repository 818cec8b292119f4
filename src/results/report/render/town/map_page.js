// Maps: names of lanes under the pointer, axes that follow the view, and places as a scenario writes them.
for (const town of document.querySelectorAll(".town")) {
  const svg = town.querySelector(".map svg"), axes = svg.querySelector(".axes"), kept = svg.querySelector(".kept");
  const here = town.querySelector(".here"), places = town.querySelector(".places");
  const lanes = JSON.parse(town.querySelector("script").textContent);
  const whole = svg.viewBox.baseVal, all = { x: whole.x, y: whole.y, width: whole.width, height: whole.height };
  const key = `${location.pathname} ${town.id}`;
  const stored = (() => { try { return JSON.parse(sessionStorage.getItem(key)); } catch { return null; } })();
  let view = stored?.view ?? { ...all }, pins = stored?.pins ?? [];
  const keep = () => { try { sessionStorage.setItem(key, JSON.stringify({ view, pins })); } catch { /* A browser may forbid it. */ } };
  const digits = (number, count) => String(Number(number.toFixed(count)));

  // The part of the ground that the picture shows is larger than the view on one side: the picture keeps its proportions.
  const shown = () => {
    const box = svg.getBoundingClientRect(), scale = Math.max(view.width / box.width, view.height / box.height);
    const width = box.width * scale, height = box.height * scale;
    return { scale, left: view.x + view.width / 2 - width / 2, top: view.y + view.height / 2 - height / 2, width, height, box };
  };
  const at = (event) => {
    const now = shown();
    return { x: now.left + (event.clientX - now.box.left) * now.scale, y: -(now.top + (event.clientY - now.box.top) * now.scale) };
  };
  const element = (name, attributes, text) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [each, value] of Object.entries(attributes)) made.setAttribute(each, value);
    if (text !== undefined) made.textContent = text;
    return made;
  };
  const draw = () => {
    svg.setAttribute("viewBox", `${view.x} ${view.y} ${view.width} ${view.height}`);
    const now = shown(), letter = 11 * now.scale, right = now.left + now.width, bottom = now.top + now.height;
    const raw = 90 * now.scale, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].find((factor) => factor * power >= raw) * power;
    const label = (x, y, text, anchor) =>
      element("text", { x, y, style: `font-size:${letter}px;text-anchor:${anchor};paint-order:stroke;stroke:var(--ground);stroke-width:${letter / 4}` }, text);
    const parts = [];
    const number = (value) => digits(value, step < 1 ? 2 : 0);
    for (let x = Math.ceil(now.left / step) * step; x < right; x += step) {
      parts.push(element("path", { class: "rule", d: `M${x} ${now.top}V${bottom}` }));
      if (x > now.left + 4 * letter && x < right - 4 * letter) parts.push(label(x, bottom - letter / 2, number(x), "middle"));
    }
    for (let y = Math.ceil(now.top / step) * step; y < bottom; y += step) {
      parts.push(element("path", { class: "rule", d: `M${now.left} ${y}H${right}` }));
      if (y < bottom - 2 * letter && y > now.top + 2 * letter) parts.push(label(now.left + letter / 2, y + letter / 3, number(-y), "start"));
    }
    parts.push(label(right - letter / 2, bottom - letter / 2, "x, m", "end"), label(now.left + letter / 2, now.top + 1.2 * letter, "y, m", "start"));
    axes.replaceChildren(...parts);
    const radius = 6 * now.scale;
    kept.replaceChildren(...pins.map((pin) => element("circle", { class: "keptmark", cx: pin.x, cy: -pin.y, r: radius })));
  };

  // The nearest place on the centre line of a lane.
  const onLane = (lane, point) => {
    let best = null;
    for (let i = 0; i + 1 < lane.middle.length; i += 1) {
      const [s0, x0, y0, h0] = lane.middle[i], [s1, x1, y1, h1] = lane.middle[i + 1];
      const [dx, dy] = [x1 - x0, y1 - y0], length = dx * dx + dy * dy;
      const share = length > 0 ? Math.min(1, Math.max(0, ((point.x - x0) * dx + (point.y - y0) * dy) / length)) : 0;
      const [x, y] = [x0 + share * dx, y0 + share * dy], off = Math.hypot(point.x - x, point.y - y);
      if (best && best.off <= off) continue;
      const turned = ((h1 - h0 + 540) % 360) - 180;
      best = { off, x, y, s: s0 + share * (s1 - s0), heading: ((h0 + share * turned + 540) % 360) - 180 };
    }
    return best;
  };
  const read = (event) => {
    const point = at(event), target = document.elementFromPoint(event.clientX, event.clientY);
    const lane = lanes[target?.dataset?.lane];
    return { ...point, lane: lane?.name, driving: lane?.driving, on: lane && onLane(lane, point), other: lane ? null : target?.querySelector?.("title")?.textContent };
  };
  const place = (point) => `(${digits(point.x, 2)} m, ${digits(point.y, 2)} m)`;
  const pose = (on) => `(${digits(on.x, 2)} m, ${digits(on.y, 2)} m, ${digits(on.heading, 1)} deg)`;
  const tell = (event) => {
    const found = read(event);
    const where = found.on ? `${found.lane}, s ${digits(found.on.s, 1)} m, heading ${digits(found.on.heading, 1)}°` : found.other ?? "off the road";
    here.textContent = `x ${digits(found.x, 2)} m, y ${digits(found.y, 2)} m: ${where}`;
  };

  const copy = async (text, button) => {
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      // Without access to the clipboard the browser copies what is selected.
      const range = document.createRange();
      range.selectNodeContents(button.parentElement.querySelector("code"));
      getSelection().removeAllRanges();
      getSelection().addRange(range);
      document.execCommand("copy");
    }
    button.textContent = "Copied";
    setTimeout(() => { button.textContent = "Copy"; }, 1200);
  };
  const list = () => {
    const rows = pins.at(-1) ? texts(pins.at(-1)) : [];
    places.replaceChildren(...rows.map(([what, text]) => {
      const row = document.createElement("div"), code = document.createElement("code"), button = document.createElement("button"), words = document.createElement("span");
      button.type = "button";
      button.textContent = "Copy";
      button.setAttribute("aria-label", `Copy ${what}`);
      code.textContent = text;
      words.textContent = what;
      button.addEventListener("click", () => copy(text, button));
      row.append(button, code, words);
      return row;
    }));
  };
  const texts = (pin) => {
    const rows = [["the place", place(pin)]];
    if (pin.on) rows.push(["the nearest pose on the middle of the lane", pose(pin.on)]);
    if (pin.on && pin.driving) rows.push(["a piece of the lane on which the car starts, for a spawn", `ego_lane { from: ${pose(pin.on)}  length: 10 m }`]);
    if (pins.length > 1) rows.push(["the last two places, for a street", `through: [${pins.slice(-2).map(place).join(", ")}]`]);
    return rows;
  };

  const zoom = (factor, centre) => {
    const now = shown(), middle = centre ?? { x: now.left + now.width / 2, y: -(now.top + now.height / 2) };
    const most = 2 * Math.max(all.width, all.height);
    if (Math.max(view.width, view.height) * factor > most || Math.min(view.width, view.height) * factor < 4) return;
    view = { x: middle.x - (middle.x - view.x) * factor, y: -middle.y - (-middle.y - view.y) * factor, width: view.width * factor, height: view.height * factor };
    draw();
    keep();
  };
  svg.addEventListener("wheel", (event) => { event.preventDefault(); zoom(event.deltaY > 0 ? 1.2 : 1 / 1.2, at(event)); }, { passive: false });
  for (const button of town.querySelectorAll("[data-zoom]")) {
    button.addEventListener("click", () => {
      if (button.dataset.zoom === "all") { view = { ...all }; draw(); keep(); } else zoom(button.dataset.zoom === "in" ? 1 / 1.5 : 1.5);
    });
  }
  svg.addEventListener("keydown", (event) => {
    const move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (move) view = { ...view, x: view.x + move[0] * view.width * 0.15, y: view.y + move[1] * view.height * 0.15 };
    else if (event.key === "+" || event.key === "-") return zoom(event.key === "+" ? 1 / 1.5 : 1.5);
    else return;
    event.preventDefault();
    draw();
    keep();
  });

  // One pointer moves the map or keeps a place; two zoom.
  const down = new Map();
  let moved = 0;
  svg.addEventListener("pointerdown", (event) => {
    if (down.size === 0) moved = 0;
    down.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  svg.addEventListener("pointermove", (event) => {
    const before = down.get(event.pointerId);
    if (!before) return tell(event);
    const now = { x: event.clientX, y: event.clientY }, scale = shown().scale;
    moved += Math.hypot(now.x - before.x, now.y - before.y);
    if (down.size === 1 && moved > 4) {
      svg.setPointerCapture(event.pointerId);
      svg.classList.add("moves");
      view = { ...view, x: view.x - (now.x - before.x) * scale, y: view.y - (now.y - before.y) * scale };
      draw();
    } else if (down.size === 2) {
      const other = [...down].find(([id]) => id !== event.pointerId)[1];
      const spread = (point) => Math.max(20, Math.hypot(point.x - other.x, point.y - other.y));
      zoom(spread(before) / spread(now), at({ clientX: (now.x + other.x) / 2, clientY: (now.y + other.y) / 2 }));
    }
    down.set(event.pointerId, now);
  });
  const up = (event) => {
    if (!down.delete(event.pointerId)) return;
    svg.classList.remove("moves");
    if (event.type === "pointerup" && moved <= 4) {
      const { x, y, on, driving } = read(event);
      pins = [...pins.slice(-1), { x, y, on, driving }];
      tell(event);
      list();
      draw();
    }
    keep();
  };
  svg.addEventListener("pointerup", up);
  svg.addEventListener("pointercancel", up);
  for (const box of town.querySelectorAll("[data-layer][type=checkbox]")) {
    box.addEventListener("change", () => { svg.querySelector(`g[data-layer="${box.dataset.layer}"]`).style.display = box.checked ? "" : "none"; });
  }
  addEventListener("resize", draw);
  list();
  draw();
}

// A preview looks for a new version of itself twice a second.
{
  const follows = document.getElementById("follows");
  if (follows) {
    const [script, version] = JSON.parse(follows.textContent);
    window.falsifyVersion = (now) => { if (now !== version) location.reload(); };
    setInterval(() => {
      const look = document.createElement("script");
      look.src = `${script}?${Date.now()}`;
      look.onload = look.onerror = () => look.remove();
      document.head.append(look);
    }, 500);
  }
}
