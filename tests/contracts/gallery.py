"""The gallery shows every model as it is: its name, the first sentence of its "about", its drawing, its outputs' plot."""
import json
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
gallery = (root / "docs" / "gallery.md").read_text()
sections = dict(re.findall(r"^## (\w+)\n(.*?)(?=^## |\Z)", gallery, re.M | re.S))
faults = []
models = sorted((root / "models").glob("*.json"))
for path in models:
    name, model = path.stem, json.loads(path.read_text())
    text = sections.pop(name, None)
    if text is None:
        faults.append(f"{name} is not in docs/gallery.md")
        continue
    sentence = text.strip().split("\n")[0].rstrip(".")
    if not model["about"].startswith(sentence):
        faults.append(f'{name}: docs/gallery.md says what the model\'s "about" does not: {sentence}')
    scenes = list(model.get("scenes", {}))
    shown = ["svg"] + ["plot.svg"] * bool(scenes) + ["start.svg"] * ("start" in scenes[1:])
    if any(f"img/gallery/{name}.{ending}" not in text for ending in shown):
        faults.append(f"{name}: a picture is missing in docs/gallery.md")
    drawing = (root / "docs" / "img" / "gallery" / f"{name}.svg").read_text()
    drawn = set(re.findall(r'data-element="([^"]+)"', drawing))
    # A submodel is drawn by what is in it, a repeated element by its copies.
    missing = [element for element in model["elements"] if element not in drawn and
               not any(one.startswith((element + ".", element + "[")) for one in drawn)]
    if missing:
        faults.append(f"{name}: not in its drawing: {', '.join(missing)}")
faults += [f"docs/gallery.md shows {name}, which is no model" for name in sections]
print("\n".join(faults + ["scripts/gallery updates it"]) if faults else f"{len(models)} models, all shown as they are")
sys.exit(bool(faults))
