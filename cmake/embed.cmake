# embed(target namespace name file): the text of a file as `extern const std::string_view name` in porepack::<namespace>.
function(embed target namespace name file)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${file})
  file(READ ${PROJECT_SOURCE_DIR}/${file} text)
  set(source ${PROJECT_BINARY_DIR}/generated/${target}_${name}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT [[// Made of @file@.
#include <string_view>

namespace porepack::@namespace@ {
extern const std::string_view @name@;
const std::string_view @name@ = R"kernel(@text@)kernel";
}  // namespace porepack::@namespace@
]] @ONLY)
  target_sources(${target} PRIVATE ${source})
endfunction()
