"""What a claim can be judged again from, alone: its files, and the command that does it."""

from scenes import EXACT, LATE


def write_boards(folder):
    (folder / "exact.toml").write_text(EXACT)
    (folder / "late.toml").write_text(LATE)


def write(folder, name, scene, claims):
    """The files of a case; which claim stands in which line."""
    entries = [(claim.group, claim.text(f"k{index}")) for index, claim in enumerate(claims)]
    plan, places = scene.plan(name, entries)
    (folder / f"{name}.toml").write_text(plan)
    (folder / f"{name}.csv").write_text(scene.rows())
    return places


class Origin:
    """A scene and one claim on it, or none where all of the case is meant."""

    def __init__(self, scene, name, claim=None):
        self.scene, self.name, self.claim = scene, name, claim

    def claims(self):
        return [self.claim] if self.claim else []

    def text(self):
        return self.claim.text("k0") if self.claim else "(the case)"

    def size(self):
        return sum(map(len, self.scene.changes.values())) + len(self.text())

    def files(self, folder):
        folder.mkdir(parents=True, exist_ok=True)
        write_boards(folder)
        write(folder, self.name, self.scene, self.claims())


class RunOrigin(Origin):
    """A run of the rig itself."""

    def keep(self, folder):
        """Writes the files; the command that shows it again."""
        self.files(folder)
        return f"rig test {folder}/{self.name}.toml --report {folder}/report"


class CaptureOrigin(Origin):
    """A capture of another instrument."""

    def __init__(self, scene, claim, capture, content, options):
        super().__init__(scene, "c0", claim)
        self.capture, self.content, self.options = capture, content, options

    def keep(self, folder):
        """Writes the files; the command that shows it again."""
        self.files(folder)
        (folder / self.capture).write_text(self.content)
        return f'rig judge {folder}/c0.toml {folder}/{self.capture} {self.options[0]} "{self.options[1]}"'
