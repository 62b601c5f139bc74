# Installs Weft into a folder of the test's own, builds a node library against that installation, and
# runs a graph that uses it from there.  cmake -DBUILD=... -DSOURCE=... -DWORK=... -P test.cmake
function(step)
    execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(NOT status EQUAL 0)
        message(FATAL_ERROR "exit status ${status}: ${ARGN}\n${output}")
    endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
step(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
step(${CMAKE_COMMAND} -S ${SOURCE}/tests/plugin -B ${WORK}/build -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_BUILD_TYPE=Release)
step(${CMAKE_COMMAND} --build ${WORK}/build)
set(weft ${WORK}/prefix/bin/weft)
step(${weft} check ${SOURCE}/tests/plugin/checkerboard.json --nodes ${WORK}/build)
step(${weft} run ${SOURCE}/tests/plugin/checkerboard.json --nodes ${WORK}/build --quiet --set out=${WORK}/squares.exr)
if(NOT EXISTS ${WORK}/squares.exr)
    message(FATAL_ERROR "the picture was not written")
endif()

# Without --nodes the type is unknown, and the status says that the document is wrong.
execute_process(COMMAND ${weft} check ${SOURCE}/tests/plugin/checkerboard.json RESULT_VARIABLE status ERROR_VARIABLE said)
if(NOT status EQUAL 2 OR NOT said MATCHES "no node type 'checkerboard'")
    message(FATAL_ERROR "expected an unknown node type and status 2, got ${status}: ${said}")
endif()
