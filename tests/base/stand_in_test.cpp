#include "base/stand_in.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace stand_in_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string refusal(std::string_view bytes) {
  try {
    base::want_no_web_page(bytes, "a.glb");
  } catch (const base::Error& error) {
    return error.what();
  }
  return "";
}

TEST(StandIn, WebPagesAreToldFromFiles) {
  for (const char* page :
       {"<!DOCTYPE html>\n<html lang=\"en\">", "\xef\xbb\xbf\r\n <!doctype HTML>", "<html>\n",
        "<?xml version=\"1.0\"?>\n<!DOCTYPE html PUBLIC \"-//W3C//DTD XHTML 1.0\">\n",
        "<!-- 404 -->\n<HTML xmlns=\"http://www.w3.org/1999/xhtml\">"})
    EXPECT_THAT(refusal(page), AllOf(HasSubstr("a.glb: is an HTML page"), HasSubstr("again")))
        << page;
  for (const char* file : {"", "\n", "<", "<?xml version=\"1.0\"?>\n<COLLADA><htmlish/>",
                           "# <html>\nv 0 0 0\n", "glTF<html>", "<gpx><trk/></gpx>"})
    EXPECT_EQ(refusal(file), "") << file;
  EXPECT_EQ(refusal("<COLLADA>" + std::string(2000, ' ') + "<html>"), "") << "only the beginning";
}

}  // namespace stand_in_test
