// Messages of the C API: levels, limits, the caller's own way to show them.
#include <atomic>
#include <cstdarg>
#include <cstdio>

#include "crgBaseLib.h"

namespace {

std::atomic<int> level_shown = dCrgMsgLevelNotice;
std::atomic<int> warnings_left = -1, logs_left = -1;  // -1: no limit
std::atomic<int (*)(int, char*)> show = nullptr;

std::atomic<int>* limit_of(int level) {
  if (level == dCrgMsgLevelWarn) return &warnings_left;
  return level > dCrgMsgLevelWarn ? &logs_left : nullptr;
}

// Whether one more may be shown, which it then counts.
bool take_one(std::atomic<int>* limit) {
  if (limit == nullptr) return true;
  int left = limit->load();
  while (left > 0 && !limit->compare_exchange_weak(left, left - 1)) {
  }
  return left != 0;
}

const char* name_of(int level) {
  constexpr const char* kNames[] = {"", "fatal", "warning", "notice", "info", "debug"};
  return level >= dCrgMsgLevelFatal && level <= dCrgMsgLevelDebug ? kNames[level] : "message";
}

}  // namespace

void crgMsgSetLevel(int level) {
  if (level >= dCrgMsgLevelNone && level <= dCrgMsgLevelDebug) level_shown = level;
}

void crgMsgSetMaxWarnMsgs(int maxNo) { warnings_left = maxNo < 0 ? -1 : maxNo; }
void crgMsgSetMaxLogMsgs(int maxNo) { logs_left = maxNo < 0 ? -1 : maxNo; }
void crgMsgSetCallback(int (*func)(int level, char* message)) { show = func; }

int crgMsgIsPrintable(int level) {
  if (level < dCrgMsgLevelFatal || level > level_shown) return 0;
  const std::atomic<int>* limit = limit_of(level);
  return limit == nullptr || *limit != 0 ? 1 : 0;
}

void crgMsgPrint(int level, const char* format, ...) {
  if (format == nullptr || level > level_shown) return;
  char text[1024];
  std::va_list rest;
  va_start(rest, format);
  const int length = std::vsnprintf(text, sizeof text, format, rest);
  va_end(rest);
  if (length < 0) return;
  if (int (*func)(int, char*) = show) {
    func(level, text);
  } else if (take_one(limit_of(level))) {
    std::fprintf(stderr, "%s: %s", name_of(level), text);
  }
}
