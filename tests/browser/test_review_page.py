"""The review desk in Debian's chromium: seen, sorted, corrected, saved; snakemake writes what was shown."""

import csv
import os
import re
import signal
import subprocess
import time

import pytest
from small_campaign import BLOCKS, CAMPAIGN, COLUMNS, MAT, Checkout, check_out, once, simulated
from warm import commands

from freerock.models.free_parameters import SYMBOLS
from freerock.virtual_lab.virtual_record import Recording, VirtualRelease, simulate_record
from freerock.virtual_lab.write_tdms import write_records

HOSTILE = "<img src=x onerror=\"document.title='pwned'\"> & 'more'"
LINES = f"""\
tall_mat,tall_mat.tdms,,tall,mat,high,,,,"{HOSTILE.replace('"', '""')}"
# what follows is squat
squat_mat,squat_mat.tdms,,squat,mat,low,,,,
lost,not_there.tdms,,squat,mat,low,,,,
"""


def lab(folder):
    """A campaign of a record with three runs, one with a run, and one whose file is missing."""
    checkout = check_out(folder)
    (checkout / "config/config.yaml").write_text("campaigns: [small]\n")
    title = HOSTILE.replace("'", "''")
    yaml = CAMPAIGN.replace("title: Two blocks on a mat", f"title: '{title}'").replace(
        "truth: truth.json\n", ""
    )
    (checkout / "config/campaigns/small.yaml").write_text(yaml)
    (checkout / "config/campaigns/small.csv").write_bytes((COLUMNS + LINES).replace("\n", "\r\n").encode())
    shape, laser, angle = BLOCKS["tall"]
    releases = [VirtualRelease(angle, MAT, tilt_s=1.2, held_s=1.5, pause_s=1.5)] * 3
    recording = Recording(rate_hz=500.0)
    tall = simulate_record(shape, laser, "hunt_crossley", releases, seed=3, recording=recording)
    write_records(checkout / "raw/small", [("tall_mat", tall), ("squat_mat", simulated("squat", 1))])
    return checkout


@pytest.fixture(scope="module")
def analysed(tmp_path_factory):
    """The campaign, analysed but for the record whose file is missing."""

    def analyse(folder):
        done = lab(folder).snakemake()
        assert "record lost failed" in done.stderr, done.stderr

    return Checkout(once(tmp_path_factory, "reviewed", analyse))


class Desk:
    """`freerock review` of a checkout, and its page."""

    def __init__(self, checkout, browser, name="small", **size):
        environment = os.environ | {"PYTHONPATH": str(checkout / "src")}
        command = [commands() / "freerock", "review", name, "--no-browser"]
        self.server = subprocess.Popen(
            command, cwd=checkout.folder, env=environment, stdout=subprocess.PIPE, text=True
        )
        self.address = self.server.stdout.readline().split()[1]
        self.requests, self.complaints = [], []
        self.page = browser.new_page(viewport={"width": 1280, "height": 900, **size})
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("console", self.told)
        self.page.goto(self.address)

    def told(self, line):
        """A complaint of the page, but for answers that refuse (409) or are no longer wanted (410)."""
        if line.type == "error" and not any(code in line.text for code in ("409 (Conflict)", "410 (Gone)")):
            self.complaints.append(line.text)

    def until(self, script, seconds=90):
        """Wait until a script of the page says so: its own policy forbids Playwright's way of waiting."""
        end = time.monotonic() + seconds
        while not self.page.evaluate(script):
            assert time.monotonic() < end, f"never: {script}; {self.page.inner_text('body')[:800]}"
            self.page.wait_for_timeout(30)

    def open(self, test, run=""):
        self.page.locator(f'#runs tr[data-test="{test}"][data-run="{run}"]').click()
        name = f"{test}, run {run} of" if run else test
        self.until(f"!at('run').hidden && at('name').textContent.startsWith({name!r})")

    def fitted(self):
        self.until("at('work').textContent.startsWith('Fitted in')")

    def shown(self, of, kind):
        """The printed values of fits: by candidate and parameter."""
        return {
            (cell.get_attribute("data-model"), cell.get_attribute("data-parameter")): cell.get_attribute(
                "data-value"
            )
            for cell in self.page.locator(f'#numbers td[data-of="{of}"][data-as^="{kind}"]').all()
        }

    def close(self):
        self.page.close(run_before_unload=False)
        self.server.send_signal(signal.SIGINT)
        assert self.server.wait(20) == 0
        hosts = {
            url.split("/")[2].partition(":")[0]
            for url in self.requests
            if not url.startswith(("data:", "blob:"))
        }
        assert hosts == {"127.0.0.1"}
        assert self.complaints == []


@pytest.fixture
def opened(analysed, browser, tmp_path):
    """A copy of the analysed campaign at the desk."""
    import shutil

    shutil.copytree(analysed.folder, tmp_path / "copy", ignore=shutil.ignore_patterns("iocache", "log"))
    checkout = Checkout(tmp_path / "copy")
    desk = Desk(checkout, browser)
    desk.until("document.querySelectorAll('#runs tbody tr').length > 4")
    yield desk, checkout
    desk.close()


DRAGGED = """() => {
  const find = view => view.model === charts.theta ? view : (view.child_views ?? []).map(find).find(Boolean);
  const frame = [...Bokeh.index].map(find).find(Boolean).frame.bbox;
  return [frame.left, frame.right, (frame.top + frame.bottom) / 2, charts.range.start, charts.range.end];
}"""


def drag_release(desk, by_s):
    """Drag the left edge of the band by so much, as a person would with the mouse."""
    page, release = desk.page, float(desk.page.input_value("#release"))
    page.evaluate(f"charts.show({release} - 0.5, {release} + 1)")
    page.wait_for_timeout(400)
    left, right, middle, start, end = page.evaluate(DRAGGED)
    page.locator(".theta").scroll_into_view_if_needed()
    box = page.locator(".theta").bounding_box()
    x, y = box["x"] + left + (release - start) / (end - start) * (right - left), box["y"] + middle
    page.mouse.move(x, y)
    page.wait_for_timeout(200)
    page.mouse.down()
    page.mouse.move(x + 0.5 * by_s / (end - start) * (right - left), y, steps=4)
    page.mouse.move(x + by_s / (end - start) * (right - left), y, steps=4)
    page.mouse.up()
    return float(page.input_value("#release")) - release


def table(checkout, name):
    with open(checkout / f"results/small/tables/{name}.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_what_is_seen_is_what_snakemake_writes(opened):
    desk, checkout = opened
    page = desk.page
    before = (checkout / "config/campaigns/small.csv").read_bytes()
    page.get_by_role("button", name="Run", exact=True).click()
    names = page.locator("#runs tbody td:nth-child(2) span").all_inner_texts()
    assert names == ["tall_mat · 1", "tall_mat · 2", "tall_mat · 3", "squat_mat · 1", "lost"]
    page.get_by_role("button", name="Verdict", exact=True).click()
    assert page.locator("#runs tbody td:nth-child(2) span").all_inner_texts()[0] == "lost"

    desk.open("tall_mat", "1")
    desk.until("document.querySelectorAll('#numbers td[data-of=run]').length > 3")
    saved = desk.shown("run", "saved")
    assert 0.015 < drag_release(desk, 0.020) < 0.025
    desk.fitted()
    moved = desk.shown("run", "corrected")
    assert moved.keys() >= saved.keys() and moved != saved

    desk.open("tall_mat", "2")
    page.get_by_label("exclude this run").check()
    page.get_by_label("Reason").fill("a knock at the table, seen")
    desk.until("at('work').textContent.startsWith('Fitting')", 10)
    desk.fitted()
    desk.open("tall_mat", "1")
    desk.fitted()
    run, means = desk.shown("run", "corrected"), desk.shown("mean", "corrected")

    page.get_by_role("button", name="Save…").click()
    assert page.locator("#sure tbody tr").count() == 3
    page.locator("#sure-save").click()
    desk.until("!at('sure').open")
    after = (checkout / "config/campaigns/small.csv").read_bytes()
    lines, old = after.split(b"\r\n"), before.split(b"\r\n")
    assert [i for i, line in enumerate(lines) if line != old[i]] == [1]
    assert b",2,1@" in lines[1] and b',"a knock at the table, seen","' in lines[1]
    log = (checkout / "config/campaigns/small.review.csv").read_text(encoding="utf-8").splitlines()
    assert [line.split(",")[4] for line in log[1:]] == ["override", "exclude", "reason"]

    jobs = checkout.planned()
    assert (jobs["record"], jobs["fit"], jobs["quality"]) == (1, 1, 1)
    done = checkout.snakemake("results/small/tables/parameters.csv")
    assert done.returncode == 0, done.stderr
    written = {
        (row["run"], row["model"], row["parameter"]): row["value"]
        for row in table(checkout, "parameters")
        if row["test"] == "tall_mat"
    } | {
        ("mean", row["model"], row["parameter"]): row["mean"]
        for row in table(checkout, "populations")
        if row["test"] == "tall_mat" and row["level"] == "record"
    }
    symbols = {symbol: name for name, symbol in SYMBOLS.items()}
    for of, number, values in (("run", "1", run), ("mean", "mean", means)):
        checked = 0
        for (model, symbol), value in values.items():
            kind, _, count = symbol.partition(" ")
            if kind == "ε_θ":
                continue
            name = symbols[kind] + (f"_{count}" if count else "")
            assert written[number, model, name] == value, (of, model, symbol)
            checked += 1
        assert checked >= 5


def test_a_stretch_and_an_impact_are_left_out(opened):
    """By the stretch shown, by a click on an impact, by hand; the reason comes next; saved in one cell."""
    desk, checkout = opened
    page = desk.page
    desk.open("tall_mat", "1")
    desk.until("charts.sources.impacts.data.x.length > 4")
    impacts = page.evaluate("charts.sources.impacts.data.x")
    page.evaluate(f"charts.show({impacts[2] - 0.02}, {impacts[2] + 0.03})")
    page.keyboard.press("b")
    stretch = f"{impacts[2] - 0.02:.3f}:{impacts[2] + 0.03:.3f}"
    assert page.evaluate("document.activeElement.id") == "reason"
    assert [float(each) for each in page.input_value("#stretches").split(":")] == [
        float(each) for each in stretch.split(":")
    ]
    page.get_by_label("Reason").fill("the cable was hit")
    desk.fitted()
    page.evaluate(f"charts.show({impacts[0] - 0.5}, {impacts[0] + 0.5})")
    page.wait_for_timeout(400)
    left, right, middle, start, end = page.evaluate(DRAGGED)
    page.locator(".theta").scroll_into_view_if_needed()
    box = page.locator(".theta").bounding_box()
    page.mouse.click(
        box["x"] + left + (impacts[0] - start) / (end - start) * (right - left), box["y"] + middle
    )
    desk.until("charts.sources.named.data.x.length === 1", 10)
    desk.until("at('work').textContent.startsWith('Fitting')", 10)
    desk.fitted()
    told = page.locator("#reasons li").all_inner_texts()
    assert [each.endswith("left out: the cable was hit") for each in told] == [True, True], told
    page.get_by_label("Left out").fill("from here")
    assert "12.310:12.450" in page.inner_text("#work")
    page.get_by_label("Left out").fill(f"{stretch};@{impacts[0]:.4f}")
    page.get_by_role("button", name="Save…").click()
    page.locator("#sure-save").click()
    desk.until("!at('sure').open")
    line = (checkout / "config/campaigns/small.csv").read_bytes().split(b"\r\n")[1].decode()
    first, second = line.split(",")[6].split(";")
    assert (float(first.removeprefix("@")), second) == (round(impacts[0], 4), stretch)
    assert "the cable was hit" in line


def test_a_look_is_noted_and_what_is_saved_is_undone(opened):
    desk, checkout = opened
    page, path = desk.page, checkout / "config/campaigns/small.csv"
    before = path.read_bytes()
    desk.open("squat_mat", "1")
    page.get_by_label("Note").fill('said "fine", <b>twice</b>')
    page.keyboard.press("Escape")
    page.keyboard.press("s")
    page.get_by_label("Why, for the log").fill("heard it")
    page.keyboard.press("Enter")
    desk.until("!at('sure').open && !at('undo').disabled")
    assert b'"said ""fine"", <b>twice</b>"' in path.read_bytes()
    page.get_by_role("button", name="Undo last save").click()
    desk.until("at('undo').disabled")
    assert path.read_bytes() == before
    desk.open("squat_mat", "1")
    page.keyboard.press("l")
    desk.until("at('counts').textContent.includes('1 looked at')")
    assert "looked_at" in (checkout / "config/campaigns/small.review.csv").read_text(encoding="utf-8")


def test_the_second_editor_is_told_and_loses_nothing(opened):
    desk, checkout = opened
    page, path = desk.page, checkout / "config/campaigns/small.csv"
    desk.open("squat_mat", "1")
    page.get_by_label("Note").fill("mine")
    path.write_bytes(path.read_bytes().replace(b"low,,,,\r\nlost", b"low,,,,\r\n# theirs\r\nlost"))
    page.get_by_role("button", name="Save…").click()
    page.get_by_label("Why, for the log").fill("mine")
    page.locator("#sure-save").click()
    desk.until("at('sure-alert').textContent.includes('was changed by someone else')")
    assert b"mine" not in path.read_bytes()
    page.get_by_role("button", name="Read the file again").click()
    desk.until("!at('sure').open")
    assert page.get_by_label("Note").input_value() == "mine"
    page.get_by_role("button", name="Save…").click()
    page.get_by_label("Why, for the log").fill("mine")
    page.locator("#sure-save").click()
    desk.until("!at('sure').open")
    assert b"# theirs" in path.read_bytes() and b",mine\r\n" in path.read_bytes()


def test_by_keyboard_alone(opened):
    desk, _ = opened
    page = desk.page
    desk.until("!at('run').hidden && !!charts")
    first = page.inner_text("#name")
    page.keyboard.press("j")
    desk.until(f"!at('name').textContent.startsWith({first!r})")
    page.keyboard.press("k")
    desk.until(f"at('name').textContent.startsWith({first!r})")
    for _ in range(5):
        if page.inner_text("#name").startswith("tall_mat, run 2"):
            break
        name = page.inner_text("#name")
        page.keyboard.press("j")
        desk.until(f"!at('name').textContent.startsWith({name!r})")
    release = float(page.input_value("#release"))
    page.keyboard.press("r")
    page.keyboard.press("ArrowUp")
    desk.fitted()
    assert float(page.input_value("#release")) == pytest.approx(release + 0.001, abs=0.0011)
    page.keyboard.press("Escape")
    page.keyboard.press("x")
    assert page.evaluate("document.activeElement.id") == "reason"
    page.keyboard.press("Escape")
    desk.until("at('verdict').textContent === 'left out'")
    page.keyboard.press("d")
    desk.until("desk.pending.size === 0 && at('verdict').textContent !== 'left out'")
    assert float(page.input_value("#release")) == release


def test_hostile_texts_show_as_texts(opened):
    desk, _ = opened
    desk.open("tall_mat", "1")
    assert desk.page.inner_text("#title") == HOSTILE
    assert desk.page.get_by_label("Note").input_value() == HOSTILE
    assert desk.page.locator("img").count() == 0
    assert desk.page.title() == "small – freerock review"


def test_a_failed_record_says_why(opened):
    desk, _ = opened
    desk.open("lost")
    assert "not_there.tdms" in desk.page.inner_text("#reasons")


def test_a_campaign_that_was_never_analysed(browser, tmp_path):
    desk = Desk(lab(tmp_path / "never"), browser)
    desk.until("document.querySelectorAll('#runs tbody tr').length === 3")
    desk.open("squat_mat")
    desk.until("desk.record.picture && charts?.sources.theta.data.t.length > 100")
    desk.fitted()
    assert ("hunt_crossley", "λ") in desk.shown("run", "saved")
    desk.page.locator("#misfit summary").click()
    desk.page.locator("#misfit .bk-Figure").wait_for(timeout=60_000)
    assert desk.page.inner_text("#alert") == ""
    desk.close()


def test_read_only_says_so(analysed, browser, tmp_path):
    if os.geteuid() == 0:
        pytest.skip("root writes everywhere")
    checkout = lab(tmp_path / "locked")
    (checkout / "config/campaigns/small.csv").chmod(0o444)
    desk = Desk(checkout, browser)
    desk.until("at('state').textContent.includes('be written: corrections are tried, but not kept')")
    assert desk.page.get_by_role("button", name="Save…").is_disabled()
    desk.close()


def test_the_cursor_reads_the_rotation_and_other_runs_lie_over_the_run(opened):
    desk, _ = opened
    desk.open("tall_mat", "1")
    desk.until("charts.sources.theta.data.t.length > 100")
    box = desk.page.locator(".theta").bounding_box()
    desk.page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"], steps=4)
    desk.until("at('cursor').textContent.includes('σ')")
    time_s, angle = re.match(r"(\S+) s +θ = (\S+)°", desk.page.inner_text("#cursor")).groups()
    t, v = desk.page.evaluate("[[...charts.sources.theta.data.t], [...charts.sources.theta.data.v]]")
    nearest = min(range(len(t)), key=lambda i: abs(t[i] - float(time_s)))
    assert float(angle) == pytest.approx(v[nearest], abs=0.001)
    assert desk.page.evaluate("charts.sources.overlay.data.t.length") == 0
    desk.page.check("#overlay")
    desk.until("charts.sources.overlay.data.t.length > 100")
    first = desk.page.evaluate("[charts.sources.overlay.data.t[0], desk.view.picture.release]")
    assert first[0] == pytest.approx(first[1], abs=0.01)
    desk.page.uncheck("#overlay")
    desk.until("charts.sources.overlay.data.t.length === 0")


def test_a_narrow_window_needs_no_sideways_scroll(opened):
    desk, _ = opened
    desk.page.set_viewport_size({"width": 390, "height": 844})
    desk.open("tall_mat", "1")
    assert desk.page.evaluate("document.documentElement.scrollWidth") <= 390
    assert desk.page.locator("#reason").bounding_box()["width"] > 150
