// The mesh comes from a process of its own through memory that the system counts as a file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <string>

#include "mesh/error.h"
#include "mesh/read_mesh.h"
#include "support/mesh_files.h"
#include "support/temporary_folder.h"

namespace file_limit_test {

TEST(FileLimit, IsNoDamageOfTheMesh) {
  const support::TemporaryFolder folder;
  road::Mesh mesh = support::small_road();
  while (mesh.vertices_m.size() < 1000) mesh.vertices_m.push_back(mesh.vertices_m.front());
  const std::string path = folder.file("a.glb", support::as_glb(mesh));
  rlimit was{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &was), 0);
  const rlimit most{4096, was.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &most), 0);
  std::string said;
  try {
    road::MeshReadOptions options;
    options.own_process = true;
    road::read_mesh(path, options);
  } catch (const road::Error& error) {
    said = error.what();
  }
  ::setrlimit(RLIMIT_FSIZE, &was);
  std::signal(SIGXFSZ, handler);
  EXPECT_THAT(said, ::testing::HasSubstr("a.glb: read, it takes more than the 4096 bytes that "
                                         "'ulimit -f' allows"));
}

}  // namespace file_limit_test
