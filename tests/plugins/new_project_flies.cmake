# Writes a plugin project for each kind, builds and tests it against the build tree by its README's
# steps, then flies one scenario with all four. cmake -D SKYBODY=program -D SKYBODY_DIR=build tree
# -D FOLDER=where -P this file
function(run folder)
  execute_process(COMMAND ${ARGN} WORKING_DIRECTORY "${folder}" RESULT_VARIABLE result
    OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN}\nin ${folder} gives ${result}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")
set(path "")
foreach(kind controller sensor effect randomizer task)
  set(project "${FOLDER}/my_${kind}")
  run("${FOLDER}" "${SKYBODY}" new ${kind} my_${kind})
  # -O1 compiles faster than the default and gives the same bits.
  run("${project}" "${CMAKE_COMMAND}" -B build "-DSkybody_DIR=${SKYBODY_DIR}"
    -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG")
  run("${project}" "${CMAKE_COMMAND}" --build build)
  run("${project}" "${CMAKE_CTEST_COMMAND}" --test-dir build --output-on-failure --no-tests=error)
  string(APPEND path "${project}/build/plugins:")
endforeach()

file(WRITE "${FOLDER}/all.yaml" "name: all_four
stepping: {dt: 0.001, action_repeat: 1, horizon: 500}
robots:
  - name: quad
    model: qdrone2
    pose: {position: [0, 0, 1]}
    rotor_speed: hover
    controllers: [{plugin: my_controller}, {plugin: rotor_speed}]
sensors: [{plugin: my_sensor, parameters: {robot: quad}}]
effects: [{plugin: my_effect}]
randomization: [{plugin: my_randomizer}]
task: {plugin: my_task}
")
set(ENV{SKYBODY_PLUGIN_PATH} "${path}")
run("${FOLDER}" "${SKYBODY}" plugins)
foreach(kind controller sensor effect randomizer task)
  if(NOT output MATCHES "my_${kind} ")
    message(FATAL_ERROR "`skybody plugins` does not list my_${kind}:\n${output}")
  endif()
endforeach()
run("${FOLDER}" "${SKYBODY}" run all.yaml --policy hold --out flight)
set(hash "${SKYBODY}" hash all.yaml --envs 1 --threads 1 --batch 1 --steps 1000 --seed 7)
run("${FOLDER}" ${hash})
set(first "${output}")
run("${FOLDER}" ${hash})
if(NOT first STREQUAL output)
  message(FATAL_ERROR "two hashes: ${first} and ${output}")
endif()

# A library whose name differs from its plugin's is found through the list file beside it. Without
# the option PLUGINS the list file disappears.
set(project "${FOLDER}/my_controller")
set(library "${project}/build/plugins/laws.so")
file(READ "${project}/CMakeLists.txt" original)
string(REPLACE "my_controller.cpp)" "my_controller.cpp PLUGINS my_controller)
set_target_properties(my_controller PROPERTIES OUTPUT_NAME laws)" changed "${original}")
file(REMOVE "${project}/build/plugins/my_controller.so")
file(WRITE "${project}/CMakeLists.txt" "${changed}")
run("${project}" "${CMAKE_COMMAND}" --build build --target my_controller)
run("${FOLDER}" ${hash})
if(NOT first STREQUAL output)
  message(FATAL_ERROR "with PLUGINS another hash: ${first} and ${output}")
endif()
string(REPLACE " PLUGINS my_controller" "" changed "${changed}")
file(WRITE "${project}/CMakeLists.txt" "${changed}")
run("${project}" "${CMAKE_COMMAND}" --build build --target my_controller)
if(NOT EXISTS "${library}" OR EXISTS "${project}/build/plugins/laws.plugins")
  message(FATAL_ERROR "${library} is missing, or laws.plugins is still beside it")
endif()
execute_process(COMMAND "${SKYBODY}" check all.yaml WORKING_DIRECTORY "${FOLDER}" RESULT_VARIABLE
  result
  ERROR_VARIABLE output)
if(NOT result EQUAL 2 OR NOT output MATCHES "unknown controller `my_controller`")
  message(FATAL_ERROR "${library} promises laws, and yet my_controller was found:\n${output}")
endif()
