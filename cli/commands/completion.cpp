// bgsim completion: scripts by which shells complete bgsim's commands, options and files. The options are asked of the
// commands' own help, so that the scripts know what the installed bgsim knows.
#include <CLI/CLI.hpp>
#include <iostream>

#include "bgsim/model.hpp"
#include "bgsim/text.hpp"
#include "command.hpp"

namespace bgsim::cli {

namespace {

const char* const kBash = R"sh(# Completion of bgsim for bash and, through bashcompinit, zsh.
# Names that others chose (scenes, files) are never expanded as words of the shell: compgen -W would run what they say.
_bgsim_offer() {
  local each
  while IFS= read -r each; do [[ $each == "$word"* ]] && COMPREPLY+=("$each"); done
}
_bgsim() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=run commands each files='!*.json'
  commands=$(bgsim --help 2>/dev/null | sed -n '/^Commands/,/^$/s/^  \([a-z]*\) .*/\1/p')
  while IFS= read -r each; do [[ ${COMP_WORDS[1]} == "$each" ]] && command=$each; done <<< "$commands"
  [[ $command == plot ]] && files='!*.csv'
  COMPREPLY=()
  case $before in
    --scene)
      for each in "${COMP_WORDS[@]}"; do
        [[ -f $each && $each == *.json && $each != -* ]] || continue
        _bgsim_offer < <(bgsim completion scenes "$each" 2>/dev/null)
        return
      done ;;
    explain) _bgsim_offer < <(bgsim explain 2>/dev/null | cut -d' ' -f1); return ;;
    new) _bgsim_offer < <(bgsim new 2>/dev/null | sed -n 's/^  \([a-z_]*\) .*/\1/p'); return ;;
    --record) _bgsim_offer <<< $'all\nstates\noutputs'; return ;;
    completion) _bgsim_offer <<< $'bash\nzsh\nfish'; return ;;
  esac
  if [[ $word == -* ]]; then
    _bgsim_offer < <(bgsim "$command" --help 2>/dev/null | grep -o -- '--[a-z][a-z-]*' | sort -u)
    return
  fi
  ((COMP_CWORD == 1)) && _bgsim_offer <<< "$commands"
  while IFS= read -r each; do COMPREPLY+=("$each"); done < <(compgen -f -X "$files" -- "$word"; compgen -d -S / -- "$word")
}
complete -o nospace -o filenames -F _bgsim bgsim
)sh";

const char* const kZsh = R"sh(autoload -U +X bashcompinit && bashcompinit
)sh";

const char* const kFish = R"sh(# Completion of bgsim for fish.
function __bgsim_commands
  bgsim --help 2>/dev/null | sed -n '/^Commands/,/^$/s/^  \([a-z]*\) *\(.*\)/\1\t\2/p'
end
function __bgsim_options
  set -l words (commandline -opc)
  set -l command run
  if contains -- "$words[2]" (__bgsim_commands | string split -f1 \t)
    set command $words[2]
  end
  bgsim $command --help 2>/dev/null | string match -r -a -- '--[a-z][a-z-]*' | sort -u
end
complete -c bgsim -n '__fish_is_first_arg' -a '(__bgsim_commands)'
complete -c bgsim -n 'string match -q -- "-*" (commandline -ct)' -a '(__bgsim_options)'
complete -c bgsim -l record -x -a 'all states outputs'
complete -c bgsim -n '__fish_seen_subcommand_from explain' -f -a '(bgsim explain | cut -d" " -f1)'
complete -c bgsim -n '__fish_seen_subcommand_from completion' -f -a 'bash zsh fish'
)sh";

/// A scene a line, for the scripts; names that a line cannot show as they are are left out.
void list_scenes(const std::string& file) {
  for (const Scene& scene : read_model(file).scenes)
    if (visible_line(scene.name) == scene.name) std::cout << scene.name << '\n';
}

}  // namespace

Exit completion_command(const Arguments& arguments) {
  std::string shell, file;
  CLI::App app("Prints a script that completes bgsim's commands, options, scenes and files.", "bgsim completion");
  app.add_option("shell", shell, "bash, zsh or fish")->required();
  app.add_option("model.json", file, "for the scripts: \"scenes\" and a model's file print the names of its scenes");
  app.footer(
      "Examples:\n  source <(bgsim completion bash)                     now, in this shell (zsh likewise)\n"
      "  bgsim completion bash > ~/.local/share/bash-completion/completions/bgsim\n"
      "  bgsim completion fish > ~/.config/fish/completions/bgsim.fish");
  parse_arguments(app, arguments);

  if (file.empty() != (shell != "scenes"))
    throw UsageError("a model's file goes with \"scenes\", and only with it: bgsim completion scenes model.json");
  if (shell == "scenes")
    list_scenes(file);
  else if (shell == "bash")
    std::cout << kBash;
  else if (shell == "zsh")
    std::cout << kZsh << kBash;
  else if (shell == "fish")
    std::cout << kFish;
  else
    throw UsageError("no completion for \"" + short_name(shell) + "\": there is one for bash, zsh and fish");
  return Exit::done;
}

}  // namespace bgsim::cli
