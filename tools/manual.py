#!/usr/bin/env python3
"""Manual pages and completion for bash and zsh, from the programs' own help.

manual.py SEAM SEAM_RENDER SHARE: SHARE/man/man1/*.1, SHARE/bash-completion/completions/seam,
SHARE/zsh/site-functions/_seam.
"""
import pathlib
import re
import subprocess
import sys

LISTS = {"Positionals": "ARGUMENTS", "Options": "OPTIONS", "Subcommands": "COMMANDS"}


def output_of(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


class Help:
    """One command's help, taken apart."""

    def __init__(self, text):
        self.about, self.usage, self.rest = "", "", ""
        self.lists = {name: [] for name in LISTS}
        into = None
        for line in text.splitlines():
            if line.rstrip(":") in LISTS and line.endswith(":"):
                into = self.lists[line.rstrip(":")]
            elif line.startswith("Usage: "):
                self.usage = line[7:]
            elif into is not None and line.startswith("  ") and not self.rest:
                item = re.match(r"  (\S.*?)(?:  +(\S.*))?$", line)
                if item and not line.startswith("   "):
                    into.append([item[1], item[2] or ""])
                else:
                    into[-1][1] = f"{into[-1][1]} {line.strip()}".strip()
            elif not self.usage:
                self.about = f"{self.about} {line}".strip()
            elif line or self.rest:
                into = None
                self.rest += line + "\n"

    def commands(self):
        return [name for name, _ in self.lists["Subcommands"]]

    def options(self):
        """(--name, its words to choose from, whether a value follows), one each."""
        found = []
        for head, _ in self.lists["Options"]:
            names, _, value = head.partition(" ")
            choice = re.search(r"\{([^}]*)\}", value)
            for name in names.split(","):
                if name.startswith("--"):
                    found.append((name, choice[1].split(",") if choice else [], bool(value)))
        return found


def all_help(program):
    """{"seam": Help, "seam add": Help, ...} from the page of all commands."""
    page = output_of(program, "help", "--markdown")
    name, found = pathlib.Path(program).name, {}
    for block in re.finditer(r"(?:^## `([^`]+)`\n\n)?^```text\n(.*?)^```$", page, re.M | re.S):
        found[block[1] or name] = Help(block[2])
    return found


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\n".join("\\&" + line if line[:1] in (".", "'") else line for line in text.split("\n"))


def man_page(name, page, version, see):
    title = name.replace(" ", "-")
    lines = [f'.TH {roff(title.upper())} 1 "" "{version}" "SEAM"', ".SH NAME", f"{roff(title)} \\- {roff(page.about)}",
             ".SH SYNOPSIS", f".B {roff(page.usage)}"]
    for key, heading in LISTS.items():
        if page.lists[key]:
            lines.append(f".SH {heading}")
        for head, about in page.lists[key]:
            lines += [".TP", f".B {roff(head)}", roff(about) or "\\&"]
    if page.rest.strip():
        lines += [".SH NOTES AND EXAMPLES", ".nf", roff(page.rest.strip()), ".fi"]
    if see:
        lines += [".SH SEE ALSO", ",\n".join(f".BR {roff(other)} (1)" for other in see).replace(",\n", " ,\n")]
    return "\n".join(lines) + "\n"


def write_manuals(pages, versions, folder):
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("seam*.1"):
        old.unlink()
    for name, page in pages.items():
        above = name.rpartition(" ")[0]
        see = ([above] if above else []) + [f"{name} {below}" for below in page.commands() if below != "help"]
        text = man_page(name, page, versions[name.split()[0]], [other.replace(" ", "-") for other in see])
        (folder / f"{name.replace(' ', '-')}.1").write_text(text)


BASH = """# Completion of seam for bash, made from its help.
_seam() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} path=seam at
  for ((at = 1; at < COMP_CWORD; at++)); do
    case "$path ${COMP_WORDS[at]}" in
      @COMMANDS@) path="$path ${COMP_WORDS[at]}" ;;
    esac
  done
  local words= choices=
  case "$path" in
@WORDS@
  esac
  case "$path $before" in
@CHOICES@
  esac
  COMPREPLY=()
  if [ -n "$choices" ]; then
    mapfile -t COMPREPLY < <(compgen -W "$choices" -- "$word")
  elif [[ $word == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  else
    mapfile -t COMPREPLY < <(compgen -W "$(for w in $words; do [[ $w == -* ]] || echo "$w"; done)" -- "$word")
    [ ${#COMPREPLY[@]} -gt 0 ] || compopt -o default 2>/dev/null
  fi
}
complete -F _seam seam
"""


def bash_completion(pages, effects):
    words, choices = [], []
    for name, page in pages.items():
        known = page.commands() + [option for option, _, _ in page.options()]
        if any(head.split()[0] == "EFFECT" for head, _ in page.lists["Positionals"]):
            known += effects
        words.append(f"    '{name}') words='{' '.join(known)}' ;;")
        for option, some, _ in page.options():
            if some:
                choices.append(f"    '{name} {option}') choices='{' '.join(some)}' ;;")
    commands = "|".join(f"'{name}'" for name in pages if " " in name)
    text = BASH.replace("@COMMANDS@", commands).replace("@WORDS@", "\n".join(words))
    return text.replace("@CHOICES@", "\n".join(choices))


ZSH = """#compdef seam
# Completion of seam for zsh, made from its help.
_seam() {
  local where=seam at
  for ((at = 2; at < CURRENT; at++)); do
    case "$where ${words[at]}" in
      @COMMANDS@) where="$where ${words[at]}" ;;
    esac
  done
  local -a known options
  case "$where" in
@WORDS@
  esac
  case "$where ${words[CURRENT-1]}" in
@CHOICES@
  esac
  [[ ${words[CURRENT]} == -* ]] || (( ! ${#known} )) || { _describe command known; return }
  [[ ${words[CURRENT]} == -* ]] && { _describe -o option options; return }
  _files
}
compdef _seam seam
"""


def zsh_entry(name, about):
    return "'{}:{}'".format(name, about.replace("'", "").replace(":", " "))


def zsh_completion(pages, effects):
    words, choices = [], []
    for name, page in pages.items():
        about = {head.split(" ")[0].split(",")[-1]: text for head, text in page.lists["Options"]}
        known = [zsh_entry(command, text) for command, text in page.lists["Subcommands"]]
        if any(head.split()[0] == "EFFECT" for head, _ in page.lists["Positionals"]):
            known += [f"'{effect}'" for effect in effects]
        options = [zsh_entry(option, about.get(option, "")) for option, _, _ in page.options()]
        words.append(f"    '{name}') known=({' '.join(known)}); options=({' '.join(options)}) ;;")
        choices += [f"    '{name} {option}') compadd {' '.join(some)}; return ;;"
                    for option, some, _ in page.options() if some]
    commands = "|".join(f"'{name}'" for name in pages if " " in name)
    text = ZSH.replace("@COMMANDS@", commands).replace("@WORDS@", "\n".join(words))
    return text.replace("@CHOICES@", "\n".join(choices))


def main():
    seam, render, share = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
    pages = all_help(seam)
    versions = {"seam": output_of(seam, "--version").strip(), "seam-render": output_of(render, "--version").strip()}
    effects = re.findall(r"^  (\w+)  ", output_of(seam, "effects"), re.M)
    if "add" not in pages["seam"].commands() or not pages["seam add"].options() or len(effects) < 10:
        sys.exit("manual.py: the help has another form than this script reads")
    write_manuals({**pages, "seam-render": Help(output_of(render, "--help"))}, versions, share / "man" / "man1")
    for text, place in ((bash_completion(pages, effects), "bash-completion/completions/seam"),
                        (zsh_completion(pages, effects), "zsh/site-functions/_seam")):
        (share / place).parent.mkdir(parents=True, exist_ok=True)
        (share / place).write_text(text)


main()
