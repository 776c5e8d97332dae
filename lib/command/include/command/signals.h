#pragma once

namespace command {

class Terminal;

/// SIGINT and SIGTERM (SIGHUP too, unless it is ignored) end the process from now on, whatever its
/// threads are doing: files that were being written are as they were before, one line says so, the
/// exit code is 128 + signal. A file beyond the shell's limit (ulimit -f) is an error of whoever
/// writes it. Call it before any thread starts.
void end_on_signals(Terminal& terminal);

/// For the terminal's destructor: from now on nothing is said through it. Does not return when a
/// signal is ending the process.
void say_nothing_more(const Terminal& terminal);

/// In a child between fork and exec: signals are as the shell gave them, and it ends with its
/// parent.
void end_with_parent() noexcept;

}  // namespace command
