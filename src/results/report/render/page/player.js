// Plays an episode from above. Positions are in centimetres, angles in milliradians. y points north, so the canvas is flipped.
class Player {
  constructor(host, data) {
    this.host = host;
    this.data = data;
    this.end = data.ego.length - 1;
    // Playback starts near the danger; the scrub bar reaches the whole episode.
    this.tick = data.opens;
    this.rate = 1;
    this.follow = true;
    this.zoom = 1;
    this.playing = false;
    this.fresh = true;
    this.build();
    this.colours();
    this.draw();
  }

  build() {
    const make = (tag, properties, ...children) => {
      const element = Object.assign(document.createElement(tag), properties);
      element.append(...children);
      return element;
    };
    this.scene = make("canvas", { className: "scene", tabIndex: 0 });
    this.scene.setAttribute("role", "img");
    this.trace = make("canvas", { className: "trace" });
    this.trace.setAttribute("aria-hidden", "true");
    this.says = make("div", { className: "says" });
    this.bar = make("input", { type: "range", min: 0, max: this.end, step: 1, value: this.tick });
    this.bar.setAttribute("aria-label", "Time");
    this.button = make("button", { type: "button", className: "play", textContent: "Play" });
    const step = (by, text, label) => {
      const button = make("button", { type: "button", textContent: text, onclick: () => this.step(by) });
      button.setAttribute("aria-label", label);
      return button;
    };
    this.speed = make("select", {}, ...[0.25, 0.5, 1, 2, 4].map((rate) => make("option", { value: rate, textContent: rate + "×", selected: rate === 1 })));
    this.speed.setAttribute("aria-label", "Speed");
    this.camera = make("button", { type: "button", textContent: "Follow" });
    this.camera.setAttribute("aria-pressed", "true");
    this.camera.title = "Follow keeps the car in the middle, Whole shows the whole way";
    const zoom = (by, text, label) => {
      const button = make("button", { type: "button", textContent: text, onclick: () => this.magnify(by) });
      button.setAttribute("aria-label", label);
      return button;
    };
    this.host.append(
      this.scene, this.says, this.trace, this.bar,
      make("div", { className: "bar" }, this.button, step(-1, "‹", "One tick back"), step(1, "›", "One tick forward"), this.speed,
        make("span", { className: "gap" }), this.camera, zoom(1 / 1.4, "−", "Zoom out"), zoom(1.4, "+", "Zoom in")));
    this.button.addEventListener("click", () => this.toggle());
    this.scene.addEventListener("click", () => this.toggle());
    this.bar.addEventListener("input", () => { this.pause(); this.seek(Number(this.bar.value)); });
    this.speed.addEventListener("change", () => { this.rate = Number(this.speed.value); });
    this.camera.addEventListener("click", () => {
      this.follow = !this.follow;
      this.camera.setAttribute("aria-pressed", this.follow);
      this.camera.textContent = this.follow ? "Follow" : "Whole";
      this.draw();
    });
    const drag = (event) => {
      if (event.type === "pointermove" && !event.buttons) return;
      const box = this.trace.getBoundingClientRect();
      this.pause();
      this.seek(Math.round((event.clientX - box.left) / box.width * this.end));
    };
    this.trace.addEventListener("pointerdown", drag);
    this.trace.addEventListener("pointermove", drag);
    this.host.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const typed = event.target.tagName;
      if (typed === "SELECT" || (event.key === " " && typed === "BUTTON")) return;
      const far = Math.round(1 / this.data.dt);
      const keys = {
        " ": () => this.toggle(),
        ArrowLeft: () => this.step(event.shiftKey ? -far : -1), ArrowRight: () => this.step(event.shiftKey ? far : 1),
        Home: () => this.step(-this.end), End: () => this.step(this.end),
        "+": () => this.magnify(1.4), "-": () => this.magnify(1 / 1.4),
      };
      if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
    });
    document.addEventListener("colours", () => { this.colours(); this.draw(); });
    new ResizeObserver(() => this.draw()).observe(this.scene);
  }

  colours() {
    const style = getComputedStyle(document.documentElement);
    this.colour = new Proxy({}, { get: (_, name) => style.getPropertyValue("--" + name).trim() });
  }

  toggle() { this.playing ? this.pause() : this.play(); }

  play() {
    if (this.tick >= this.end) this.tick = this.data.opens;
    this.playing = true;
    this.fresh = false;
    this.button.textContent = "Pause";
    let last = null, exact = this.tick;
    const frame = (now) => {
      if (!this.playing) return;
      if (last !== null) exact += Math.min(now - last, 100) / 1000 * this.rate / this.data.dt;
      last = now;
      this.seek(Math.min(this.end, Math.floor(exact)), Math.min(this.end, exact));
      if (exact >= this.end) this.pause(); else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  pause() { this.playing = false; this.button.textContent = "Play"; }

  step(by) { this.pause(); this.seek(this.tick + by); }

  magnify(by) { this.zoom = Math.min(6, Math.max(0.4, this.zoom * by)); this.draw(); }

  seek(tick, exact = tick) {
    this.tick = Math.max(0, Math.min(this.end, tick));
    this.draw(exact);
  }

  // A state between two ticks; an angle is interpolated the short way round.
  between(states, exact) {
    const from = Math.max(0, Math.min(this.end, Math.floor(exact))), share = Math.max(0, Math.min(this.end, exact)) - from;
    // A parked car has one state.
    const at = (tick) => states[Math.min(states.length - 1, tick)], a = at(from), b = at(Math.min(this.end, from + 1));
    const turn = ((b[2] - a[2] + 9425) % 6283 + 6283) % 6283 - 3142;
    return { x: (a[0] + (b[0] - a[0]) * share) / 100, y: (a[1] + (b[1] - a[1]) * share) / 100, yaw: (a[2] + turn * share) / 1000, speed: (a[3] + (b[3] - a[3]) * share) / 100 };
  }

  mode(tick) { return this.data.modes.filter(([from]) => from <= tick).pop()[1].replaceAll("_", " "); }

  seen(tick) { return this.data.sight.filter((change) => change <= tick).length % 2 === 1; }

  // Sets a canvas to the pixels of the screen and returns its context in those of the page.
  paper(canvas) {
    const box = canvas.getBoundingClientRect(), ratio = devicePixelRatio || 1;
    const width = Math.round(box.width * ratio), height = Math.round(box.height * ratio);
    if (!width || !height) return null;
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, box.width, box.height);
    return { context, width: box.width, height: box.height };
  }

  draw(exact = this.tick) {
    const ego = this.between(this.data.ego, exact), person = this.between(this.data.person, exact);
    this.drawScene(ego, person, exact);
    this.drawTrace();
    this.tell(ego, person);
    this.bar.value = this.tick;
  }

  view(ego, person, width, height) {
    if (this.follow) {
      const across = Math.max(26, Math.abs(person.x - ego.x) * 1.2 + 10), up = Math.max(14, Math.abs(person.y - ego.y) * 1.2 + 10);
      return { x: (ego.x + person.x) / 2, y: (ego.y + person.y) / 2, scale: Math.min(width / across, height / up) * this.zoom };
    }
    const all = this.data.ego.concat(this.data.person), of = (i) => all.map((state) => state[i] / 100);
    const [left, right, low, high] = [Math.min(...of(0)), Math.max(...of(0)), Math.min(...of(1)), Math.max(...of(1))];
    return { x: (left + right) / 2, y: (low + high) / 2, scale: Math.min(width / (right - left + 14), height / (high - low + 14)) * this.zoom };
  }

  drawScene(ego, person, exact) {
    const paper = this.paper(this.scene);
    if (!paper) return;
    const { context: c, width, height } = paper, { data, colour } = this;
    const view = this.view(ego, person, width, height);
    c.fillStyle = colour.ground;
    c.fillRect(0, 0, width, height);
    c.save();
    c.translate(width / 2, height / 2);
    c.scale(view.scale, -view.scale);
    c.translate(-view.x, -view.y);
    const kinds = ["walk", "lane", "marking", "zebra", "house"].map((name) => colour[name]);
    for (const polygon of data.scenery) {
      c.beginPath();
      for (let i = 1; i < polygon.length; i += 2) c.lineTo(polygon[i] / 10, polygon[i + 1] / 10);
      c.fillStyle = kinds[polygon[0]];
      c.fill();
    }
    const path = (states, stroke, from) => {
      c.beginPath();
      for (let i = from; i <= this.tick; i++) c.lineTo(states[i][0] / 100, states[i][1] / 100);
      c.strokeStyle = stroke;
      c.lineWidth = 1.6 / view.scale;
      c.stroke();
    };
    const begun = Math.max(0, this.tick - Math.round(6 / data.dt));
    path(data.ego, colour.car, begun);
    path(data.person, colour.person, begun);
    const eye = { x: ego.x + Math.cos(ego.yaw) * (data.car[0] / 100 - 1.9), y: ego.y + Math.sin(ego.yaw) * (data.car[0] / 100 - 1.9) };
    const seen = this.seen(this.tick);
    c.beginPath();
    c.moveTo(eye.x, eye.y);
    c.lineTo(person.x, person.y);
    c.setLineDash(seen ? [] : [4 / view.scale, 4 / view.scale]);
    c.strokeStyle = seen ? colour.seen : colour.muted;
    c.lineWidth = 1.4 / view.scale;
    c.stroke();
    c.setLineDash([]);
    for (const other of data.others ?? []) this.drawOther(c, other, this.between(other.states, exact), view.scale);
    this.drawCar(c, ego);
    this.drawPerson(c, person, view.scale);
    if (data.touch && this.tick === this.end) {
      c.beginPath();
      c.arc(person.x, person.y, 1.3, 0, 7);
      c.strokeStyle = colour.brake;
      c.lineWidth = 2.5 / view.scale;
      c.stroke();
    }
    c.restore();
    this.drawScale(c, view.scale, width, height);
    if (this.fresh) this.drawPlay(c, height);
  }

  // A sign that a click on the picture plays it.
  drawPlay(c, height) {
    c.fillStyle = this.colour.accent;
    c.beginPath();
    c.arc(34, height - 34, 22, 0, 7);
    c.fill();
    c.fillStyle = this.colour.edge;
    c.beginPath();
    c.moveTo(28, height - 44);
    c.lineTo(45, height - 34);
    c.lineTo(28, height - 24);
    c.fill();
  }

  drawCar(c, ego) {
    const [length, side] = [this.data.car[0] / 100, this.data.car[1] / 100], braking = this.data.brake[this.tick] > 4;
    c.save();
    c.translate(ego.x, ego.y);
    c.rotate(ego.yaw);
    const box = (x, y, w, h, r, fill) => { c.beginPath(); c.roundRect(x, y, w, h, r); c.fillStyle = fill; c.fill(); };
    box(-length, -side, 2 * length, 2 * side, 0.45, this.colour.car);
    c.globalAlpha = 0.75;
    box(length * 0.22, -side * 0.82, length * 0.3, side * 1.64, 0.2, this.colour.ground);
    box(-length * 0.72, -side * 0.75, length * 0.22, side * 1.5, 0.2, this.colour.ground);
    c.globalAlpha = 1;
    if (braking) for (const y of [-side, side - 0.5]) box(-length - 0.22, y, 0.34, 0.5, 0.1, this.colour.brake);
    c.restore();
  }

  // Another actor, pale, with the name of its role.
  drawOther(c, other, state, scale) {
    const [length, side] = [other.half[0] / 100, other.half[1] / 100];
    c.save();
    c.translate(state.x, state.y);
    c.globalAlpha = 0.55;
    c.beginPath();
    if (other.is_pedestrian) {
      c.fillStyle = this.colour.person;
      c.arc(0, 0, Math.max(length, 4 / scale), 0, 7);
      c.fill();
    } else {
      c.save();
      c.rotate(state.yaw);
      c.fillStyle = this.colour.car;
      c.roundRect(-length, -side, 2 * length, 2 * side, 0.3);
      c.fill();
      c.restore();
    }
    c.globalAlpha = 1;
    c.scale(1 / scale, -1 / scale);
    c.font = "11px system-ui, sans-serif";
    c.fillStyle = this.colour.muted;
    c.fillText(other.name, 8, -8);
    c.restore();
  }

  drawPerson(c, person, scale) {
    // A disc of 0.25 m would hardly be visible, so a visible pedestrian has a ring.
    const size = Math.max(this.data.radius / 100, 5 / scale);
    c.save();
    c.translate(person.x, person.y);
    c.rotate(person.yaw);
    c.fillStyle = this.colour.person;
    c.beginPath();
    c.moveTo(size * 2.1, 0);
    c.lineTo(size * 0.7, size * 0.75);
    c.lineTo(size * 0.7, -size * 0.75);
    c.fill();
    c.beginPath();
    c.arc(0, 0, size, 0, 7);
    c.fill();
    c.lineWidth = 1.5 / scale;
    c.strokeStyle = this.colour.edge;
    c.stroke();
    c.restore();
  }

  drawScale(c, scale, width, height) {
    const metres = [1, 2, 5, 10, 20, 50].find((each) => each * scale > 40) || 100, long = metres * scale;
    c.fillStyle = this.colour.ink;
    c.fillRect(width - 14 - long, height - 13, long, 2);
    c.font = "11px system-ui, sans-serif";
    c.textAlign = "right";
    c.fillText(metres + " m", width - 14, height - 18);
  }

  drawTrace() {
    const paper = this.paper(this.trace);
    if (!paper) return;
    const { context: c, width, height } = paper, { data, colour } = this;
    const most = Math.max(3, ...data.ego.map((state) => state[3] / 100), ...data.person.map((state) => state[3] / 100));
    const floor = height - 4, x = (tick) => tick / Math.max(1, this.end) * width, y = (speed) => floor - speed / most * (height - 22);
    if (data.danger !== null) {
      c.fillStyle = colour.h1;
      c.globalAlpha = 0.45;
      c.fillRect(x(data.danger), 0, width - x(data.danger), floor);
      c.globalAlpha = 1;
    }
    c.fillStyle = colour.brake;
    c.globalAlpha = 0.5;
    data.brake.forEach((brake, tick) => { if (brake > 4) c.fillRect(x(tick - 0.5), floor - 3 * brake / 100, width / this.end + 0.5, 3 * brake / 100); });
    c.globalAlpha = 1;
    for (const [states, stroke] of [[data.person, colour.person], [data.ego, colour.car]]) {
      c.beginPath();
      states.forEach((state, tick) => c.lineTo(x(tick), y(state[3] / 100)));
      c.strokeStyle = stroke;
      c.lineWidth = 1.6;
      c.stroke();
    }
    c.font = "11px system-ui, sans-serif";
    c.textAlign = "left";
    c.fillStyle = colour.muted;
    // Both labels are in a line above the curves.
    const label = "speed, up to " + most.toFixed(1) + " m/s";
    c.fillText(label, 2, 11);
    if (data.danger !== null) {
      const word = "danger", least = c.measureText(label).width + 14;
      c.fillText(word, Math.min(Math.max(least, x(data.danger)), width - c.measureText(word).width - 2), 11);
    }
    // A violated requirement has a mark where its episode is decided.
    for (const [row, [tick, name]] of (data.violations ?? []).entries()) {
      c.fillStyle = colour.brake;
      c.fillRect(x(tick) - 1, 14, 2, floor - 14);
      c.fillText(name, Math.min(x(tick) + 4, width - c.measureText(name).width - 5), 24 + 12 * row);
    }
    c.fillStyle = colour.ink;
    c.fillRect(x(this.tick) - 0.75, 0, 1.5, height);
  }

  tell(ego, person) {
    const { data, tick } = this, gap = Math.max(0, this.gap(ego, person));
    const bold = (text) => { const b = document.createElement("b"); b.textContent = text; return b; };
    const line = (...parts) => { const span = document.createElement("span"); span.append(...parts); return span; };
    const touched = data.touch && tick === this.end;
    const brake = data.brake[tick];
    this.says.replaceChildren(
      line(bold((tick * data.dt).toFixed(2) + " s"), " · car ", bold(ego.speed.toFixed(1)), " m/s · pedestrian ", bold(person.speed.toFixed(1)), " m/s"),
      line(touched ? bold("touch") : "gap " + gap.toFixed(1) + " m, " + (this.seen(tick) ? "in sight" : "hidden")),
      line("driver: ", bold(this.mode(tick)), brake > 4 ? " · brake " + brake + " %" : ""));
    this.scene.setAttribute("aria-label", [...this.says.children].map((part) => part.textContent).join(", "));
    this.bar.setAttribute("aria-valuetext", (tick * data.dt).toFixed(2) + " seconds");
  }

  // From the pedestrian's disc to the car's box.
  gap(ego, person) {
    const [dx, dy] = [person.x - ego.x, person.y - ego.y], [cos, sin] = [Math.cos(ego.yaw), Math.sin(ego.yaw)];
    const ahead = Math.abs(dx * cos + dy * sin) - this.data.car[0] / 100, aside = Math.abs(dy * cos - dx * sin) - this.data.car[1] / 100;
    return Math.hypot(Math.max(ahead, 0), Math.max(aside, 0)) + Math.min(Math.max(ahead, aside), 0) - this.data.radius / 100;
  }
}

for (const host of document.querySelectorAll(".player")) {
  new Player(host, JSON.parse(document.getElementById(host.dataset.replay).textContent));
}

// A link to a player plays it above the page, with its title.
document.addEventListener("click", (event) => {
  const link = event.target.closest("a[href^='#play-']"), script = link && document.getElementById(link.hash.slice(1) + "-data");
  if (!script) return;
  event.preventDefault();
  const make = (tag, properties, ...children) => {
    const element = Object.assign(document.createElement(tag), properties);
    element.append(...children);
    return element;
  };
  const host = make("div", { className: "player" }), title = make("h3", { textContent: script.dataset.title });
  const close = make("button", { type: "button", textContent: "Close", onclick: () => dialog.close() });
  const dialog = make("dialog", {}, make("header", {}, title, close), make("p", { textContent: script.dataset.short }), host);
  dialog.setAttribute("aria-label", script.dataset.title);
  document.body.append(dialog);
  dialog.showModal();
  const player = new Player(host, JSON.parse(script.textContent));
  dialog.addEventListener("close", () => { player.pause(); dialog.remove(); });
  dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close(); });
  player.button.focus();
  player.play();
});
