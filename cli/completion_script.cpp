#include <fmt/core.h>

#include <functional>
#include <stdexcept>

#include "cli/command_tree.h"

namespace firn {
namespace {

using Visit = std::function<void(const CommandTree&, const std::string& path)>;

// Every command with the words that lead to it: "", "runs", "runs pack".
void each_command(const CommandTree& tree, const std::string& path, const Visit& visit) {
  visit(tree, path);
  for (const CommandTree& c : tree.subcommands)
    each_command(c, path + (path.empty() ? "" : " ") + c.name, visit);
}

std::string with_between(const std::vector<std::string>& words, const std::string& between) {
  std::string all;
  for (const std::string& w : words) all += (all.empty() ? "" : between) + w;
  return all;
}

// In single quotes, for all three shells: their rules differ only in a quote inside.
std::string in_quotes(const std::string& text, bool fish = false) {
  std::string all = "'";
  for (const char c : text)
    all += c == '\'' ? (fish ? "\\'" : "'\\''") : c == '\\' && fish ? "\\\\" : std::string(1, c);
  return all + "'";
}

// "word:help" of _describe, in which a colon of the word is escaped.
std::string described(const std::string& word, const std::string& help) {
  std::string all;
  for (const char c : word) all += c == ':' ? "\\:" : std::string(1, c);
  return all + ":" + help;
}

std::string bash_script(const CommandTree& program) {
  std::string words, values;
  each_command(program, "", [&](const CommandTree& c, const std::string& path) {
    std::vector<std::string> all;
    for (const CommandTree& s : c.subcommands) all.push_back(s.name);
    for (const DescribedOption& o : c.options) {
      if (o.positional) {
        all.insert(all.end(), o.choices.begin(), o.choices.end());
        continue;
      }
      all.insert(all.end(), o.names.begin(), o.names.end());
      if (!o.value.empty())
        for (const std::string& name : o.names)
          values += fmt::format("  [{}]={}\n", in_quotes(path + " " + name),
                                in_quotes(with_between(o.choices, " ")));
    }
    words += fmt::format("  [{}]={}\n", in_quotes("/" + path), in_quotes(with_between(all, " ")));
  });
  return "# Completion of firn in bash; written by: firn completion bash\n"
         "declare -gA _firn_words=(\n" +
         words + ")\ndeclare -gA _firn_values=(\n" + values +
         R"()
_firn() {
  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} path='' word
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    [[ -z ${_firn_words["/$path${path:+ }$word"]+x} ]] || path+="${path:+ }$word"
  done
  local known=${_firn_words["/$path"]}
  [[ -z ${_firn_values["$path $before"]+x} ]] || known=${_firn_values["$path $before"]}
  mapfile -t COMPREPLY < <(compgen -W "$known" -- "$current")
}
complete -o default -F _firn firn
)";
}

std::string zsh_script(const CommandTree& program) {
  std::string words, values;
  each_command(program, "", [&](const CommandTree& c, const std::string& path) {
    std::string all;
    const auto add = [&](const std::string& word, const std::string& help) {
      all += (all.empty() ? "" : "\n") + described(word, help);
    };
    for (const CommandTree& s : c.subcommands) add(s.name, s.summary);
    for (const DescribedOption& o : c.options) {
      if (o.positional) {
        for (const std::string& choice : o.choices) add(choice, o.help);
        continue;
      }
      for (const std::string& name : o.names) {
        add(name, o.help);
        if (!o.value.empty())
          values += fmt::format("    {} {}\n", in_quotes(path + " " + name),
                                in_quotes(with_between(o.choices, " ")));
      }
    }
    words += fmt::format("    {} {}\n", in_quotes("/" + path), in_quotes(all));
  });
  return "#compdef firn\n# Completion of firn in zsh; written by: firn completion zsh\n"
         "_firn() {\n  local -A known=(\n" +
         words + "  )\n  local -A values=(\n" + values +
         R"(  )
  local path_='' word
  for word in "${(@)words[2,CURRENT-1]}"; do
    (( ${+known[/$path_${path_:+ }$word]} )) && path_+="${path_:+ }$word"
  done
  local option="$path_ ${words[CURRENT-1]}"
  if (( ${+values[$option]} )); then
    local -a choices=(${=values[$option]})
    (( $#choices )) && compadd -a choices || _files
    return
  fi
  local -a described=("${(@f)known[/$path_]}")
  _describe 'firn' described || _files
}
[[ $zsh_eval_context[-1] == loadautofunc ]] && _firn "$@" || compdef _firn firn
)";
}

std::string fish_script(const CommandTree& program) {
  std::string script = "# Completion of firn in fish; written by: firn completion fish\n";
  each_command(program, "", [&](const CommandTree& c, const std::string& path) {
    std::string when = "__fish_use_subcommand";
    if (!path.empty()) {
      when.clear();
      std::string words = path;
      for (char& ch : words)
        if (ch == ' ') ch = '\n';
      for (std::size_t at = 0; at <= words.size();) {
        const std::size_t end = std::min(words.find('\n', at), words.size());
        when +=
            (when.empty() ? "" : "; and ") + ("__fish_seen_subcommand_from " + words.substr(at, end - at));
        at = end + 1;
      }
    }
    const std::string line = "complete -c firn -n " + in_quotes(when, true);
    for (const CommandTree& s : c.subcommands)
      script += fmt::format("{} -a {} -d {}\n", line, in_quotes(s.name, true), in_quotes(s.summary, true));
    for (const DescribedOption& o : c.options) {
      if (o.positional) {
        if (!o.choices.empty())
          script += fmt::format("{} -a {} -d {}\n", line, in_quotes(with_between(o.choices, " "), true),
                                in_quotes(o.help, true));
        continue;
      }
      script += line;
      for (const std::string& name : o.names)
        script += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (!o.value.empty())
        script += o.choices.empty() ? " -r" : " -x -a " + in_quotes(with_between(o.choices, " "), true);
      script += " -d " + in_quotes(o.help, true) + "\n";
    }
  });
  return script;
}

}  // namespace

std::string completion_script(const CommandTree& program, const std::string& shell) {
  if (shell == "bash") return bash_script(program);
  if (shell == "zsh") return zsh_script(program);
  if (shell == "fish") return fish_script(program);
  throw std::invalid_argument("no completion for the shell '" + shell + "'; there are bash, zsh, fish");
}

}  // namespace firn
