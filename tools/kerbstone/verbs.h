// What the other programs do, by one name: 'kerbstone build' starts 'crgbuild build', as git does.
// They stay programs of their own, with licences of their own.
#pragma once

#include <string>
#include <vector>

namespace kerbstone {

struct Verb {
  const char *name, *program;
  const char* command;            ///< of that program; empty: the word behind the verb is one
  std::vector<const char*> also;  ///< words behind the verb that are commands in its place
  const char* about;
};

const std::vector<Verb>& verbs();

/// The program's name and its words for `kerbstone VERB ...`, flags before the verb put behind it;
/// empty where the first word is none of verbs().
std::vector<std::string> words_of_owner(const std::vector<std::string>& words);

/// Where this program lies: the others lie beside it. Empty where the system does not say.
std::string own_folder();

/// A file of the examples ("tracks/kerbstone-ring/circuit.yaml"): of a package, or of the tree in
/// which this was built; empty: neither.
std::string example_file(const std::string& own, const std::string& name);

/// The programs beside this one are found from now on, also in a tree that was built and not
/// installed, where each has a folder of its own. `own`: the folder of this program.
void make_tools_found(const std::string& own);

/// Becomes that program. Returns only where it cannot be started: what to do.
std::string become(std::vector<std::string> words);

/// A line for each verb, for --help.
std::string verbs_text();

}  // namespace kerbstone
