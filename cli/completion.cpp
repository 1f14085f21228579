// bgsim completion: scripts by which shells complete bgsim's commands, options and files. The options are asked of the
// commands' own help, so that the scripts know what the installed bgsim knows.
#include <CLI/CLI.hpp>
#include <iostream>

#include "command.hpp"

namespace bgsim::cli {

namespace {

const char* const kBash = R"sh(# Completion of bgsim for bash and, through bashcompinit, zsh.
_bgsim() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=run commands each files='!*.json'
  commands=$(bgsim --help 2>/dev/null | sed -n '/^Commands/,/^$/s/^  \([a-z]*\) .*/\1/p')
  for each in $commands; do [[ ${COMP_WORDS[1]} == "$each" ]] && command=$each; done
  [[ $command == plot ]] && files='!*.csv'
  COMPREPLY=()
  case $before in
    --scene)
      for each in "${COMP_WORDS[@]}"; do
        [[ -f $each && $each == *.json ]] || continue
        local scenes
        scenes=$(bgsim show --stage model "$each" 2>/dev/null | sed -n 's/^scene \([^ :]*\).*/\1/p')
        COMPREPLY=($(compgen -W "$scenes" -- "$word"))
        return
      done ;;
    explain) COMPREPLY=($(compgen -W "$(bgsim explain 2>/dev/null | cut -d' ' -f1)" -- "$word")); return ;;
    new) COMPREPLY=($(compgen -W "$(bgsim new 2>/dev/null | sed -n 's/^  \([a-z_]*\) .*/\1/p')" -- "$word")); return ;;
    completion) COMPREPLY=($(compgen -W "bash zsh fish" -- "$word")); return ;;
  esac
  if [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W "$(bgsim $command --help 2>/dev/null | grep -o -- '--[a-z][a-z-]*' | sort -u)" -- "$word"))
    return
  fi
  ((COMP_CWORD == 1)) && COMPREPLY=($(compgen -W "$commands" -- "$word"))
  COMPREPLY+=($(compgen -f -X "$files" -- "$word") $(compgen -d -S / -- "$word"))
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
complete -c bgsim -n '__fish_seen_subcommand_from explain' -f -a '(bgsim explain | cut -d" " -f1)'
complete -c bgsim -n '__fish_seen_subcommand_from completion' -f -a 'bash zsh fish'
)sh";

}  // namespace

Exit completion_command(const Arguments& arguments) {
  std::string shell;
  CLI::App app("Prints a script that completes bgsim's commands, options, scenes and files.", "bgsim completion");
  app.add_option("shell", shell, "bash, zsh or fish")->required();
  app.footer(
      "Examples:\n  source <(bgsim completion bash)                     now, in this shell (zsh likewise)\n"
      "  bgsim completion bash > ~/.local/share/bash-completion/completions/bgsim\n"
      "  bgsim completion fish > ~/.config/fish/completions/bgsim.fish");
  parse_arguments(app, arguments);

  if (shell == "bash")
    std::cout << kBash;
  else if (shell == "zsh")
    std::cout << kZsh << kBash;
  else if (shell == "fish")
    std::cout << kFish;
  else
    throw UsageError("no completion for \"" + shell + "\": there is one for bash, zsh and fish");
  return Exit::done;
}

}  // namespace bgsim::cli
