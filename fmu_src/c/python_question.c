/* Asks the Python on PATH where its library is.
 *
 * It is a process of its own, which may die of what would end the host's process too.  Each part of the answer is a line
 * with a mark, because a sitecustomize or a wrapper around Python may print lines of its own, before and after.
 */
#ifndef _WIN32
#define _POSIX_C_SOURCE 200809L
#endif

#include "python_question.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#define popen _popen
#define pclose _pclose
#define PYTHON "python"
#define NO_INPUT " <NUL"
#define UNSET "set %s=&"
#define NOT_FOUND(status) ((status) == 9009)
#define FIND_LIBRARY "c=[sys.base_prefix+'/python3.dll'];"
#else
#include <sys/wait.h>
#define PYTHON "python3"
#define NO_INPUT " </dev/null" /* PYTHONINSPECT makes Python wait for input */
#define UNSET "unset %s;"
#define NOT_FOUND(status) (WIFEXITED(status) && WEXITSTATUS(status) == 127)
#define FIND_LIBRARY                                                                                                   \
    "g=sysconfig.get_config_var;d=g('LIBDIR') or '';n='libpython'+sysconfig.get_python_version();"                     \
    "c=[p+'/'+f for p in (d,d+'/'+(g('MULTIARCH') or ''),sys.base_prefix+'/lib')"                                      \
    " for f in (g('INSTSONAME') or n,n+'.so.1.0',n+'.so') if '.so' in f];"
#endif

/* The words are written without print, which a sitecustomize may have replaced. */
#define QUESTION                                                                                                       \
    PYTHON " -c \"import os,sys,sysconfig;" FIND_LIBRARY                                                               \
           "a=[sys.executable or '','.'.join(map(str,sys.version_info[:3])),'64' if sys.maxsize>2**32 else '32',"      \
           "next(filter(os.path.isfile,c),'')];"                                                                       \
           "os.write(1,os.fsencode(''.join(chr(10)+'psp-'+k+':'+v for k,v in zip(('executable','version','bits',"      \
           "'library'),a))+chr(10)))\"" NO_INPUT " 2>&1"

/* Copies what comes behind the mark, if `line` begins with it. */
static bool take(const char *line, const char *mark, char *part, size_t size)
{
    const size_t length = strlen(mark);
    if (strncmp(line, mark, length) != 0) return false;
    snprintf(part, size, "%s", line + length);
    return true;
}

static void read_line(Answer *answer, const char *line)
{
    if (take(line, "psp-executable:", answer->executable, sizeof answer->executable) ||
        take(line, "psp-version:", answer->version, sizeof answer->version) ||
        take(line, "psp-bits:", answer->bits, sizeof answer->bits) ||
        take(line, "psp-library:", answer->library, sizeof answer->library))
        return;
    if (strspn(line, " \t") != strlen(line) && (strstr(line, "rror") || !strstr(answer->said, "rror")))
        snprintf(answer->said, sizeof answer->said, "%.500s", line);
}

bool answered(const Answer *answer) { return answer->version[0] != '\0'; }

Answer ask_python_on_path(const char *without)
{
    Answer answer = {"", "", "", "", "", false};
    char command[2048] = "", line[2048];
    if (without) snprintf(command, sizeof command, UNSET " ", without);
    strcat(command, QUESTION);
    FILE *stream = popen(command, "r");
    if (!stream) return answer;
    while (fgets(line, sizeof line, stream)) {
        line[strcspn(line, "\r\n")] = '\0';
        read_line(&answer, line);
    }
    const int status = pclose(stream);
    answer.found = answered(&answer) || !NOT_FOUND(status);
    if (answer.said[0] == '\0') snprintf(answer.said, sizeof answer.said, "it said nothing");
    return answer;
}
