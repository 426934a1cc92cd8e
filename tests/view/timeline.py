"""A finished run in time: the slider, play, clicks on the path, and links; on a phone, too."""

import xml.etree.ElementTree

from harness import Browser, await_that, check

NUM_SCANS = """
const callback = arguments[0];
import('/main.js').then(({robots}) => callback(robots[0].model.timeline ? robots[0].model.timeline.num : 0));
"""

# Goes to a scan. Callback: where the robot is then, and how many rays are drawn.
GO_TO = """
const [number, callback] = arguments;
import('/main.js').then(({robots, player}) => {
  const {model} = robots[0];
  player.goTo(number);
  const {timeline} = model;
  const soon = (tries) => {
    if (!(model.scan && timeline.isAt(model.scan)) && tries > 0) return setTimeout(() => soon(tries - 1), 20);
    callback({at: timeline.at, x_m: timeline.x_m[timeline.at], robot_x_m: model.robot.x_m, rays: model.scan.rays.length,
              slider: Number(document.getElementById('moment').value), time: document.getElementById('time').textContent});
  };
  soon(100);
});
"""

# Plays for two seconds. Callback: how far, and how many pictures a second.
PLAY = """
const callback = arguments[0];
import('/main.js').then(({robots, player}) => {
  player.goTo(0);
  document.getElementById('play').click();
  const began_ms = performance.now();
  let frames = 0;
  const count = (now_ms) => {
    ++frames;
    if (now_ms - began_ms < 2000) return requestAnimationFrame(count);
    document.getElementById('play').click();
    callback({frames: frames / 2, at: robots[0].model.timeline.at, playing: player.playing});
  };
  requestAnimationFrame(count);
});
"""

# Taps the path where the robot was at a scan. Callback: the scan that is shown then.
TAP = """
const [number, callback] = arguments;
import('/main.js').then(({robots}) => {
  const {model, view} = robots[0];
  const {timeline} = model;
  const box = view.canvas.getBoundingClientRect();
  const way = view.turn(timeline.x_m[number] - view.camera.x_m, timeline.y_m[number] - view.camera.y_m);
  const place = {clientX: box.left + box.width / 2 + way.right_m * view.camera.px,
                 clientY: box.top + box.height / 2 - way.up_m * view.camera.px, pointerId: 1, pointerType: 'touch'};
  view.canvas.setPointerCapture = () => {};
  for (const type of ['pointerdown', 'pointerup']) view.canvas.dispatchEvent(new PointerEvent(type, place));
  requestAnimationFrame(() => callback({at: timeline.at, away_m: Math.hypot(
      timeline.x_m[timeline.at] - timeline.x_m[number], timeline.y_m[timeline.at] - timeline.y_m[number])}));
});
"""

# Measures between two places by touch. Callback: what is said, and the true distance.
MEASURE = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {view} = robots[0];
  document.getElementById('measure').click();
  view.canvas.setPointerCapture = () => {};
  const box = view.canvas.getBoundingClientRect();
  const middle = {x: box.left + box.width / 2, y: box.top + box.height / 3};
  for (const aside of [-60, 60]) {
    const place = {clientX: middle.x + aside, clientY: middle.y, pointerId: 2, pointerType: 'touch'};
    for (const type of ['pointerdown', 'pointerup']) view.canvas.dispatchEvent(new PointerEvent(type, place));
  }
  const said = [];
  const context = view.canvas.getContext('2d');
  const {fillText} = context;
  context.fillText = (text, ...rest) => { said.push(text); fillText.call(context, text, ...rest); };
  view.stale = true;
  view.draw(performance.now());
  context.fillText = fillText;
  const cursor = document.getElementById('cursor').textContent;
  document.getElementById('measure').click();
  callback({said, cursor, distance_m: 120 / view.camera.px});
});
"""

# Two fingers that were 80 px apart are 160 px apart. Callback: how much larger the map is, and by how far the place
# between them has moved [px].
PINCH = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {view} = robots[0];
  view.canvas.setPointerCapture = () => {};
  view.setFollows(false);
  const box = view.canvas.getBoundingClientRect();
  const middle = {x: box.left + box.width / 2, y: box.top + box.height / 3};
  const point = (type, pointerId, aside) => view.canvas.dispatchEvent(new PointerEvent(type, {
      clientX: middle.x + aside, clientY: middle.y, pointerId, pointerType: 'touch'}));
  const [before, {px}] = [view.toMap(middle.x, middle.y), view.camera];
  point('pointerdown', 4, -40);
  point('pointerdown', 5, 40);
  for (let apart = 41; apart <= 80; ++apart) {
    point('pointermove', 4, -apart);
    point('pointermove', 5, apart);
  }
  point('pointerup', 4, -80);
  point('pointerup', 5, 80);
  const after = view.toMap(middle.x, middle.y);
  callback({larger: view.camera.px / px,
            moved_px: Math.hypot(after.x_m - before.x_m, after.y_m - before.y_m) * view.camera.px});
});
"""

# Turns the map. Callback: by how much, and whether a place of the window is where it is drawn.
TURN = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {view} = robots[0];
  view.camera.turn_rad = 0.4;
  const box = view.canvas.getBoundingClientRect();
  const place = view.toMap(box.left + 100, box.top + 80);
  const way = view.turn(place.x_m - view.camera.x_m, place.y_m - view.camera.y_m);
  const there = [box.width / 2 + way.right_m * view.camera.px, box.height / 2 - way.up_m * view.camera.px];
  view.camera.turn_rad = 0;
  document.getElementById('turn').click();
  const turned = view.camera.turn_rad;
  document.getElementById('turn').click();
  callback({there, turned, back: view.camera.turn_rad});
});
"""

# Callback: how much of the path's colour there is at the begin, at the end, and there without the path.
PATH_SO_FAR = """
const callback = arguments[0];
import('/main.js').then(({robots, player}) => {
  const {model, view} = robots[0];
  const wanted = [1, 3, 5].map((at) => parseInt(view.colours.path.slice(at, at + 2), 16));
  const count = (scan) => {
    player.goTo(scan);
    view.draw(performance.now());
    const {data} = view.canvas.getContext('2d').getImageData(0, 0, view.canvas.width, view.canvas.height);
    let found = 0;
    for (let at = 0; at < data.length; at += 4) found += wanted.every((value, i) => Math.abs(value - data[at + i]) < 40);
    return found;
  };
  const seen = {begin: count(0), end: count(model.timeline.num - 1)};
  const box = document.querySelector('[data-layer=path]');
  box.click();
  seen.without = count(model.timeline.num - 1);
  box.click();
  callback(seen);
});
"""

# Moves the middle of the path by half a metre, as a loop would have. Callback: how much of the loops' colour is drawn
# with the layer and without it, and at the begin.
MOVED = """
const callback = arguments[0];
import('/main.js').then(({robots, player}) => {
  const {model, view} = robots[0];
  const {timeline} = model;
  const [was, {loops}] = [timeline.first_y_m.slice(), model.info];
  for (let i = Math.floor(timeline.num / 3); i < timeline.num / 2; ++i) timeline.first_y_m[i] = timeline.y_m[i] + 0.5;
  const wanted = [1, 3, 5].map((at) => parseInt(view.colours.loop.slice(at, at + 2), 16));
  const box = document.querySelector('[data-layer=moved]');
  model.info.loops = [];
  view.fit();
  const count = (scan, shown) => {
    if (box.checked !== shown) box.click();
    player.goTo(scan);
    view.timeline_path = null;
    view.stale = true;
    view.draw(performance.now());
    const {data} = view.canvas.getContext('2d').getImageData(0, 0, view.canvas.width, view.canvas.height);
    let found = 0;
    for (let at = 0; at < data.length; at += 4) found += wanted.every((value, i) => Math.abs(value - data[at + i]) < 60);
    return found;
  };
  const seen = {without: count(timeline.num - 1, false), all: count(timeline.num - 1, true), early: count(5, true)};
  box.click();
  timeline.first_y_m.set(was);
  model.info.loops = loops;
  view.timeline_path = null;
  callback({...seen, moved: timeline.moved(0).length});
});
"""


# Shows the whole map. What covers it, and whether all of it is in the view.
COVERED = """
const callback = arguments[0];
import('/main.js').then(({robots}) => {
  const {model, view, parent} = robots[0];
  document.getElementById('fit').click();
  const box = parent.getBoundingClientRect();
  const {x0, y0, x1, y1} = model.map.extent();
  const middle = {x: box.left + box.width / 2, y: box.top + box.height / 2};
  const [left, right] = [x0, x1].map((x_m) => middle.x + (x_m - view.camera.x_m) * view.camera.px);
  const [bottom, top] = [y0, y1].map((y_m) => middle.y - (y_m - view.camera.y_m) * view.camera.px);
  const covers = ['head', 'tools', 'panel', 'player'].filter((id) => {
    const other = document.getElementById(id).getBoundingClientRect();
    return other.left < right && other.right > left && other.top < bottom && other.bottom > top;
  });
  const is_inside = left >= box.left && right <= box.right && top >= box.top && bottom <= box.bottom;
  callback({covers, is_inside, pressed: document.getElementById('fit').getAttribute('aria-pressed')});
});
"""

# Scrolls the panel. By how much its handle moves, and how high it is for a finger.
HANDLE = """
const [fold, numbers] = ['fold', 'numbers'].map((id) => document.getElementById(id));
if (fold.getAttribute('aria-expanded') === 'false') fold.click();
const before = fold.getBoundingClientRect();
numbers.scrollTop = 150;
const after = fold.getBoundingClientRect();
const scrolled = numbers.scrollTop;
numbers.scrollTop = 0;
return {moved: after.top - before.top, scrolled, height: after.height};
"""


# Callback: the view as an SVG, and as a picture.
FIGURE = """
const callback = arguments[0];
Promise.all([import('/main.js'), import('/picture.js')]).then(async ([{robots}, {composeFigure, composePicture}]) => {
  const {view, model} = robots[0];
  model.info.made_from = 'a<b>&"c" --preset sick';
  view.fit();
  await drawn();
  callback([await composeFigure(view, 'as it is', performance.now()).text(), composePicture(view, 'as it is').toDataURL()]);
});
"""

# Callback: how many pixels of them differ, as a share.
COMPARED = """
const [svg, picture, callback] = arguments;
const pixelsOf = async (address) => {
  const image = Object.assign(new Image(), {src: address});
  await image.decode();
  const context = Object.assign(document.createElement('canvas'), {width: image.width, height: image.height}).getContext('2d');
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, image.width, image.height).data;
};
Promise.all([`data:image/svg+xml,${encodeURIComponent(svg)}`, picture].map(pixelsOf)).then(([a, b]) => {
  let differ = 0;
  for (let at = 0; at < a.length; at += 4) differ += Math.abs(a[at] - b[at]) + Math.abs(a[at + 1] - b[at + 1]) > 120;
  callback(a.length === b.length ? 4 * differ / a.length : 1);
});
"""


def test_figure(browser):
    svg, picture = browser.run(FIGURE)
    words = [text.text for text in xml.etree.ElementTree.fromstring(svg).iter("{http://www.w3.org/2000/svg}text")]
    check(words[:2] == ["finished", "as it is"] and words[2].startswith('made from a<b>&"c" --preset sick') and "2 m" in words and "path" in words,
          f"an SVG has the run's name, its origin, a scale and a legend: {words}")
    errors = browser.errors()
    check(errors == [], f"the console has no errors: {errors}")
    browser.driver.get("about:blank")
    differ = browser.run(COMPARED, svg, picture)
    check(differ < 0.01, f"and is what is seen, but for {differ:.2%} of the pixels")


def test_timeline(browser, url):
    num = browser.run(NUM_SCANS)
    check(num > 1000, f"the page has all {num} scans")
    middle = browser.driver.execute_async_script(GO_TO, num // 2)
    check(middle["at"] == middle["slider"] == num // 2, f"it goes to one of them: {middle['time']}")
    check(abs(middle["x_m"] - middle["robot_x_m"]) < 1e-3 and middle["rays"] > 100, "with the pose and the rays of then")
    browser.picture("moment")
    played = browser.run(PLAY)
    check(played["at"] > 10 and not played["playing"], f"it plays, {played['frames']:.0f} pictures a second")
    tapped = browser.driver.execute_async_script(TAP, num // 3)
    check(tapped["away_m"] < 0.5, "a click on the path goes there")
    path = browser.run(PATH_SO_FAR)
    check(path["end"] > path["begin"] + 300 and path["without"] <= path["begin"], f"the path is drawn up to the moment: {path}")
    moved = browser.run(MOVED)
    check(moved["all"] > moved["without"] + 100 and moved["early"] <= moved["without"] + 20,
          f"what loops moved is drawn up to the moment: {moved}")
    turned = browser.run(TURN)
    check(max(abs(turned["there"][0] - 100), abs(turned["there"][1] - 80)) < 1e-6 and turned["back"] == 0,
          "the map turns, and a place of the window stays where it is drawn")
    test_figure(browser)
    link_to_a_moment(browser, url, num // 4)


def link_to_a_moment(browser, url, number):
    browser.driver.get("about:blank")
    link = f"scan={number}&map=last&x=1.00&y=2.00&px=33.00&turn=0.1000&layers=path+grid&theme=light"
    browser.driver.get(f"{url}#{link}")
    await_that(lambda: browser.run(NUM_SCANS) > 0, "a link is opened")
    seen = browser.run("""
        const callback = arguments[0];
        import('/main.js').then(({robots}) => setTimeout(() => callback(
            {...robots[0].view.camera, at: robots[0].model.timeline.at, hash: location.hash, theme: document.documentElement.dataset.theme,
             layers: Object.entries(robots[0].view.layers).filter(([, shown]) => shown).map(([layer]) => layer)}), 1200));""")
    check((seen["x_m"], seen["y_m"], seen["px"], seen["turn_rad"], seen["at"]) == (1, 2, 33, 0.1, number), "it shows the same place and moment")
    check((seen["layers"], seen["theme"]) == (["path", "grid"], "light"), "with the same layers, as light")
    check(seen["hash"] == f"#{link}", f"and keeps all of it: {seen['hash']}")
    browser.driver.execute_script("location.hash = 'view=follow&px=50.00&theme=dark&scan=-x&layers=%00&turn=NaN&mode=1'")
    await_that(lambda: browser.run("""
        const callback = arguments[0];
        import('/main.js').then(({robots: [{view, model}]}) => callback(
            Boolean(model.timeline) && view.follows && view.camera.px === 50 && model.timeline.at === 0));"""),
               "one is pasted that follows the robot; what is no number there changes nothing")
    browser.driver.execute_script("location.hash = 'theme=dark'")
    await_that(lambda: browser.run(NUM_SCANS) > 0, "and one of the run alone")
    playing = "import('/main.js').then(({player}) => arguments[0](player.playing));"
    for what in ("theme", "theme", "layers", "layers", "speed"):
        browser.driver.find_element("id", what).click()
    for wanted in (True, False):
        browser.driver.switch_to.active_element.send_keys(" ")
        check(browser.run(playing) == wanted, f"space after clicks: playing {wanted}")


def test_phone(url):
    for name, size in (("upright", "412,915"), ("landscape", "915,512")):
        phone = Browser(url, size)
        try:
            await_that(lambda: phone.run(NUM_SCANS) > 0, f"a phone, {name}, shows a finished run")
            seen = phone.run(MEASURE)
            wanted = f"{seen['distance_m']:.2f}"
            check(any(text.startswith(wanted[:-1]) for text in seen["said"]) and " m" in seen["cursor"],
                  f"a distance is measured by touch: {seen['said']}")
            pinched = phone.run(PINCH)
            check(abs(pinched["larger"] - 2) < 0.01 and pinched["moved_px"] < 2, f"two fingers pinch: {pinched}")
            small = phone.driver.execute_script("""
                return [...document.querySelectorAll('#tools button, #player button')].filter((button) => {
                  const {width, height} = button.getBoundingClientRect();
                  return width > 0 && Math.min(width, height) < 43.9;
                }).map(({id}) => id);""")
            check(small == [], f"no button is smaller than 44 px: {small}")
            handle = phone.driver.execute_script(HANDLE)
            check(handle["moved"] == 0 < handle["scrolled"] and handle["height"] >= 44, f"the panel scrolls below its handle: {handle}")
            covered = phone.run(COVERED)
            check(covered == {"covers": [], "is_inside": True, "pressed": "true"}, f"nothing covers the whole map: {covered}")
            hidden = phone.driver.execute_script("""
                const fold = document.getElementById('fold');
                if (fold.getAttribute('aria-expanded') === 'true') fold.click();
                return [...document.querySelectorAll('#panel section')].filter((section) =>
                    section.checkVisibility({checkVisibilityCSS: true})).map(({className}) => className);""")
            check(hidden == [], "a folded panel shows nothing of what it holds")
            phone.picture(f"finished_{name}")
            check(phone.errors() == [], "its console has no errors")
        finally:
            phone.driver.quit()


# Contrast of free cells against unexplored ones in both themes, and whether a wall of one cell is in every picture.
SEEN_AFAR = """
const callback = arguments[0];
Promise.all([import('/main.js'), import('/map_model.js')]).then(([, {MapModel, REDUCTIONS, makePalette}]) => {
  const luminance = (hex) => {
    const [red, green, blue] = [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255)
      .map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4));
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
  };
  const contrasts = ['dark', 'light'].map((theme) => {
    document.documentElement.dataset.theme = theme;
    const style = getComputedStyle(document.documentElement);
    const [ground, free] = ['--ground', '--free'].map((name) => luminance(style.getPropertyValue(name).trim()));
    return (Math.max(ground, free) + 0.05) / (Math.min(ground, free) + 0.05);
  });
  const map = new MapModel();
  map.setPalette(makePalette([0, 255, 0], [255, 0, 0]));
  const runs = new Uint8Array(4 + 4096).fill(255);
  runs.set([0, 0, 16, 0]);
  runs[4 + 64 * 20 + 37] = 0;
  map.take({x: 0, y: 0, whole: true, runs});
  map.paint();
  const walls = REDUCTIONS.map((reduction, level) => {
    const {data} = map.block(0, 0).pictures[level].getContext('2d').getImageData(0, 0, 512 / reduction, 512 / reduction);
    let found = 0;
    for (let at = 0; at < data.length; at += 4) found += data[at] > 200 && data[at + 1] < 50;
    return found;
  });
  callback({contrasts, walls});
});
"""


def test_seen_afar(browser):
    seen = browser.run(SEEN_AFAR)
    check(min(seen["contrasts"]) >= 2, f"free against unexplored: {', '.join(f'{c:.2f}' for c in seen['contrasts'])}")
    check(seen["walls"] == [1, 1, 1], "a wall of one cell is in the picture of every zoom")
