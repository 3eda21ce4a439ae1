"""Runs the steps of action.yml, and those of the release workflow that need no forge, as the runner
does: with bash, in a folder of their own, with the variables that it sets.

usage: steps.py LANDFALL WORK

LANDFALL is a build with every feature; WORK is a folder that is made anew. Needs PyYAML.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
ACTION = yaml.safe_load((ROOT / "action.yml").read_text())
RELEASE = yaml.safe_load((ROOT / ".github/workflows/release.yml").read_text())
HOOKS = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())

OWN_ACTIONS = ("actions/checkout@", "actions/upload-artifact@", "actions/download-artifact@", "actions/setup-node@")


def evaluate(expression, contexts):
    """The value of an expression: names, strings, `format` and `||`, which is all that is used."""
    depth, parts, start = 0, [], 0
    for at, char in enumerate(expression):
        depth += {"(": 1, ")": -1}.get(char, 0)
        if depth == 0 and expression.startswith("||", at):
            parts.append(expression[start:at])
            start = at + 2
    parts.append(expression[start:])
    if len(parts) > 1:
        values = [evaluate(part, contexts) for part in parts]
        return next((value for value in values if value), values[-1])
    text = expression.strip()
    call = re.fullmatch(r"format\('([^']*)',(.*)\)", text)
    if call:
        return call[1].format(*(evaluate(one, contexts) for one in call[2].split(",")))
    context, _, name = text.partition(".")
    return contexts[context].get(name, "")


def expand(text, contexts):
    return re.sub(r"\$\{\{(.*?)\}\}", lambda found: evaluate(found[1], contexts), text)


class Runner:
    """A machine of CI: its folders, and the variables that are set for each step."""

    def __init__(self, work, landfall):
        shutil.rmtree(work, ignore_errors=True)
        self.work = work
        self.project = work / "project"
        self.temporary = work / "temporary"
        self.releases = work / "forge/owner/landfall/releases/download"
        self.version = output([landfall, "--version"]).split()[1]
        self.path_file = work / "path"
        for folder in (self.project, self.temporary, self.releases / f"v{self.version}"):
            folder.mkdir(parents=True)
        self.path_file.touch()
        shaders = self.project / "shaders"
        shaders.mkdir()
        shutil.copy(ROOT / "shaders/light_arrays/lights.wgsl", shaders)
        (self.project / "landfall.toml").write_text('paths = ["shaders"]\n')
        subprocess.run([landfall, "lock", "--quiet"], cwd=self.project, check=True)

    def folder_of_release(self):
        return self.releases / f"v{self.version}"

    def environment(self):
        added = self.path_file.read_text().splitlines()
        # Nothing of the caller's but where programs are; the landfall under test is installed.
        return {
            "PATH": ":".join([*reversed(added), "/usr/local/bin:/usr/bin:/bin"]),
            "HOME": str(self.work),
            "RUNNER_TEMP": str(self.temporary),
            "GITHUB_PATH": str(self.path_file),
            "GITHUB_ACTION_PATH": str(ROOT),
            "GITHUB_ACTIONS": "true",
            "GITHUB_WORKSPACE": str(self.project),
        }

    def run(self, script, env, folder):
        return subprocess.run(
            ["bash", "--noprofile", "--norc", "-e", "-o", "pipefail", "-c", script],
            env={**self.environment(), **env},
            cwd=folder,
            text=True,
            capture_output=True,
        )

    def action(self, **inputs):
        """Runs the action; returns the exit code of its first step that fails, and all output."""
        values = {name: one.get("default", "") for name, one in ACTION["inputs"].items()}
        unknown = set(inputs) - set(values)
        assert not unknown, unknown
        values |= inputs
        github = {"server_url": f"file://{self.work}/forge", "action_repository": "owner/landfall"}
        contexts = {"inputs": values, "github": github}
        self.path_file.write_text("")
        printed = ""
        for step in ACTION["runs"]["steps"]:
            assert set(step) <= {"name", "shell", "env", "run", "working-directory"}, step
            assert step["shell"] == "bash" and "${{" not in step["run"], step
            env = {name: expand(value, contexts) for name, value in step.get("env", {}).items()}
            folder = self.project / expand(step.get("working-directory", "."), contexts)
            ran = self.run(step["run"], env, folder)
            printed += ran.stdout + ran.stderr
            if ran.returncode != 0:
                return ran.returncode, printed
        return 0, printed


def output(command):
    return subprocess.run(command, check=True, text=True, capture_output=True).stdout


def the_action(runner, landfall):
    folder = runner.folder_of_release()
    target = f"{os.uname().machine}-unknown-linux-musl"
    code, printed = runner.action(version=runner.version)
    assert code == 2 and "cannot be fetched" in printed, (code, printed)

    subprocess.run([ROOT / ".ci/archive", landfall, target, folder], check=True)
    checksums = next(s["run"] for s in RELEASE["jobs"]["draft"]["steps"] if "sha256sum" in s.get("run", ""))
    (runner.work / "packages").symlink_to(folder)
    ran = runner.run(checksums, {}, runner.work)
    assert ran.returncode == 0, ran.stderr

    code, printed = runner.action(version=runner.version)
    assert code == 0, (code, printed)
    installed = runner.temporary / "landfall/landfall"
    assert installed.read_bytes() == pathlib.Path(landfall).read_bytes()
    code, printed = runner.action(
        **{"version": f"v{runner.version}", "arguments": "--deny warnings shaders", "sarif": "a b.sarif"}
    )
    assert code == 0 and '"2.1.0"' in (runner.project / "a b.sarif").read_text(), (code, printed)

    shader = runner.project / "shaders/lights.wgsl"
    text = shader.read_text()
    drifted = text.replace("intensity: f32", "intensity: vec4<f32>", 1)
    assert drifted != text
    shader.write_text(drifted)
    code, printed = runner.action(version=runner.version)
    assert code == 1 and "::error file=shaders/lights.wgsl" in printed, (code, printed)
    shader.write_text(text)

    archive = folder / f"landfall-{runner.version}-{target}.tar.gz"
    sound = archive.read_bytes()
    archive.write_bytes(sound[:-1])
    installed.unlink()
    code, printed = runner.action(version=runner.version)
    assert code == 2 and "is not the file whose SHA-256" in printed, (code, printed)
    assert not installed.exists(), "what is not the release is not installed"
    archive.write_bytes(sound)


def the_workflow(runner):
    builds = RELEASE["jobs"]["build"]["strategy"]["matrix"]["include"]
    targets = [build["target"] for build in builds]
    systems = ("unknown-linux-gnu", "unknown-linux-musl", "apple-darwin", "pc-windows-msvc")
    assert sorted(targets) == sorted(f"{cpu}-{s}" for cpu in ("x86_64", "aarch64") for s in systems)
    known = set(output(["rustc", "--print", "target-list"]).split())
    assert set(targets) <= known, set(targets) - known
    for job in RELEASE["jobs"].values():
        for step in job["steps"]:
            assert step.get("uses", OWN_ACTIONS[0]).startswith(OWN_ACTIONS), step
            for script in re.findall(r"\.ci/\w+", step.get("run", "")):
                assert os.access(ROOT / script, os.X_OK), script
    compare = next(s["run"] for s in RELEASE["jobs"]["build"]["steps"] if "cargo metadata" in s.get("run", ""))
    for tag, code in ((f"v{runner.version}", 0), ("v9.9.9", 1)):
        env = {"GITHUB_REF_NAME": tag, "PATH": os.environ["PATH"], "HOME": os.environ["HOME"]}
        ran = runner.run(compare, env, ROOT)
        assert ran.returncode == code, (tag, ran.stderr)


def the_repository(work):
    """`.ci/repository` writes the address into every manifest, once, and refuses others."""
    copy = work / "copy"
    manifests = ["Cargo.toml", *(str(p.relative_to(ROOT)) for p in ROOT.glob("crates/*/Cargo.toml"))]
    assert len(manifests) > 5, manifests
    for name in (*manifests, ".ci/repository"):
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, copy / name)
    env = {"PATH": os.environ["PATH"], "GITHUB_SERVER_URL": "https://forge.example"}
    for owner in ("first", "second"):
        env["GITHUB_REPOSITORY"] = f"{owner}/landfall"
        subprocess.run([copy / ".ci/repository"], env=env, check=True)
    for name in manifests:
        lines = [line for line in (copy / name).read_text().splitlines() if line.startswith("repository")]
        assert lines == ['repository = "https://forge.example/second/landfall"'], (name, lines)
    for wrong in ("", "git@forge.example:a/b", 'https://forge.example/"x'):
        ran = subprocess.run([copy / ".ci/repository", wrong], env={"PATH": env["PATH"]}, capture_output=True)
        assert ran.returncode == 2, wrong


def the_hooks():
    """The hooks of pre-commit run for what decides about findings, and for nothing else."""
    assert {hook["id"] for hook in HOOKS} == {"landfall", "landfall-system"}
    for hook in HOOKS:
        assert not hook["pass_filenames"] and hook["entry"] == "landfall check", hook
        runs = re.compile(hook["files"]).search
        for path in ("a.glsl", "x/b.frag", "c.wgsl", "d.rmiss", "e.fs", "f.vsh", "layouts/a.frag.json", "landfall.toml", "p/.landfall.toml"):
            assert runs(path), path
        for path in ("a.rs", "layouts.json", "xlandfall.toml", "glsl", "a.frag.txt"):
            assert not runs(path), path


def the_container():
    """The container copies what `.ci/deb` writes and runs as a user of its own."""
    text = (ROOT / "examples/container/Containerfile").read_text()
    lines = re.sub(r"\\\n", " ", re.sub(r"(?m)^#.*\n", "", text)).split("\n")
    steps = [line.split(maxsplit=1) for line in lines if line]
    assert steps[0][0] == "FROM" and ":" in steps[0][1], "the image has a tag"
    words = {"FROM", "COPY", "RUN", "USER", "WORKDIR", "ENTRYPOINT", "CMD"}
    assert {word for word, _ in steps} <= words, steps
    assert [rest for word, rest in steps if word == "COPY"] == ["landfall_*.deb /tmp/"], steps
    assert [word for word, _ in steps].index("USER") > [word for word, _ in steps].index("RUN")
    for run in (rest for word, rest in steps if word == "RUN"):
        subprocess.run(["bash", "-n", "-c", run], check=True)


def main():
    landfall, work = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve()
    runner = Runner(work, landfall)
    the_workflow(runner)
    the_repository(work)
    the_hooks()
    the_container()
    the_action(runner, landfall)
    print("action, workflow, hooks and container: their steps run")


main()
