// Scripts: ParaView Catalyst pipelines in Python (version 2), as ParaView exports them or as pipelines/ has them.
//
// ParaView answers an error in a script by printing it, sys.exit() by leaving the process.  Here all that a script can
// raise ends in a note to the engine with its traceback, and the script is dropped; the others go on.
#include <Python.h> // before the headers of the system

#include "catalyst.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sys/stat.h>
#include <unistd.h>

#include <vtkCPDataDescription.h>
#include <vtkCPInputDataDescription.h>
#include <vtkCPProcessor.h>
#include <vtkCPPythonScriptV2Pipeline.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkPythonInterpreter.h>

#include "channels.h"
#include "engine.h"
#include "session.h"

namespace
{
// Wraps what ParaView calls of a script.  Live options that a script brings are taken from it: its link would wait for
// its client, and with it the engine for the script; --live does the same without that.
constexpr const char *GUARD = R"(
import paraview.catalyst.v2_internals as _calls
import traceback as _traceback

_tmdempm_failed, _tmdempm_notes = [], []

class _TmdempmDropped(Exception):
    pass

def _tmdempm_guard(name):
    plain = getattr(_calls, name)
    def guarded(*arguments):
        try:
            result = plain(*arguments)
        except BaseException as error:  # SystemExit and KeyboardInterrupt among them
            frames = [f for f in _traceback.extract_tb(error.__traceback__)[1:] if 'importlib' not in f.filename
                      and not f.filename.endswith('v2_internals.py')]
            lines = ['Traceback (most recent call last):\n'] + _traceback.format_list(frames)
            lines += _traceback.format_exception_only(type(error), error)
            _tmdempm_failed.append((_calls._get_script_filename() or '', ''.join(lines).rstrip()))
            raise _TmdempmDropped('a script failed: the traceback follows') from None
        if name == 'import_and_validate' and result.options.EnableCatalystLive:
            result.options.EnableCatalystLive = 0
            _tmdempm_notes.append('%s asks for a live connection, which is --live here: its own is switched off'
                                  % _calls._get_script_filename())
        return result
    setattr(_calls, name, guarded)

for _name in ('import_and_validate', 'do_request_data_description', 'do_catalyst_initialize', 'do_catalyst_execute',
              'do_catalyst_finalize'):
    _tmdempm_guard(_name)

def _tmdempm_take(what):
    return what.pop(0) if what else None
)";

std::string as_text(PyObject *object)
{
	const char *text = object && PyUnicode_Check(object) ? PyUnicode_AsUTF8(object) : nullptr;
	PyErr_Clear();
	return text ? text : "";
}

// Calls _tmdempm_take(list); a new reference, null if there is nothing.
PyObject *take(const char *list)
{
	PyObject *main = PyImport_AddModule("__main__"), *taken = nullptr;
	PyObject *function = main ? PyObject_GetAttrString(main, "_tmdempm_take") : nullptr;
	PyObject *from = main ? PyObject_GetAttrString(main, list) : nullptr;
	if (function && from)
		taken = PyObject_CallFunctionObjArgs(function, from, nullptr);
	Py_XDECREF(function);
	Py_XDECREF(from);
	PyErr_Clear();
	if (taken != Py_None)
		return taken;
	Py_DECREF(taken);
	return nullptr;
}

class scripts_task : public task
{
  public:
	~scripts_task() override
	{
		processor->Finalize(); // catalyst_finalize() of the scripts
		tell_failures();
	}

	bool start(const std::vector<std::string> &paths, const std::string &folder, std::string &error)
	{
		if (!folder.empty() && chdir(folder.c_str()) != 0) {
			error = "cannot work in " + folder;
			return false;
		}
		if (!session_start(error))
			return false;
		if (!processor->Initialize()) {
			error = "ParaView Catalyst does not start";
			return false;
		}
		for (const std::string &path : paths)
			add(path);
		if (vtkPythonInterpreter::RunSimpleString(GUARD) != 0) {
			error = "ParaView's Python does not work (its messages are in the viewer's log): reinstall python3-paraview";
			return false;
		}
		if (pipelines.empty() && !paths.empty()) {
			error = "none of the scripts can be used";
			return false;
		}
		return true;
	}

	bool work(const frame_message &request, const frame_view &frame, std::string &) override
	{
		bool wanted = false;
		channels next(frame);
		if (processor->GetNumberOfPipelines() > 0)
			wanted = run(frame, next);
		tell_failures();
		if (!wanted) {
			next.release();
			engine_send(FRAME_MSG_DONE, request.slot);
		} else {
			data = std::move(next); // the former frame has left the scripts' sources
			if (slot >= 0)
				engine_send(FRAME_MSG_DONE, slot);
			slot = request.slot;
			engine_send(FRAME_MSG_KEPT, slot);
		}
		if (pipelines.empty())
			engine_send(FRAME_MSG_FAILED, -1, "every script has failed");
		return true;
	}

  private:
	struct script {
		std::string path;
		vtkSmartPointer<vtkCPPythonScriptV2Pipeline> pipeline;
	};

	void add(const std::string &path)
	{
		auto pipeline = vtkSmartPointer<vtkCPPythonScriptV2Pipeline>::New();
		if (pipeline->Initialize(path.c_str())) {
			processor->AddPipeline(pipeline);
			pipelines.push_back({path, pipeline});
		} else {
			engine_send(FRAME_MSG_NOTE, -1, "script " + path + " dropped: it cannot be read");
		}
	}

	// False: no script wants this step.
	bool run(const frame_view &frame, const channels &now)
	{
		vtkNew<vtkCPDataDescription> description;
		description->SetTimeData(frame.header().time, vtkIdType(frame.header().step));
		for (const auto &channel : now.all())
			description->AddInput(channel.name.c_str());
		if (!processor->RequestDataDescription(description))
			return false;
		for (const auto &channel : now.all())
			description->GetInputDescriptionByName(channel.name.c_str())->SetGrid(channel.data);
		processor->CoProcess(description);
		return true;
	}

	void tell_failures()
	{
		PyGILState_STATE lock = PyGILState_Ensure();
		while (PyObject *note = take("_tmdempm_notes")) {
			engine_send(FRAME_MSG_NOTE, -1, as_text(note));
			Py_DECREF(note);
		}
		while (PyObject *failure = take("_tmdempm_failed")) {
			std::string path, words;
			if (PyTuple_Check(failure) && PyTuple_Size(failure) == 2) {
				path = as_text(PyTuple_GetItem(failure, 0));
				words = as_text(PyTuple_GetItem(failure, 1));
			}
			drop(path, words);
			Py_DECREF(failure);
		}
		PyGILState_Release(lock);
	}

	void drop(const std::string &path, const std::string &words)
	{
		for (size_t k = 0; k < pipelines.size(); k++)
			if (pipelines[k].path == path) {
				processor->RemovePipeline(pipelines[k].pipeline);
				pipelines.erase(pipelines.begin() + long(k));
				break;
			}
		constexpr size_t ROOM = FRAME_TEXT - 256;
		bool cut = words.size() > ROOM;
		if (cut)
			fprintf(stderr, "%s\n", words.c_str());
		engine_send(FRAME_MSG_NOTE, -1, "script " + path + " dropped: " +
											 (cut ? "... " + words.substr(words.size() - ROOM) : words));
	}

	vtkNew<vtkCPProcessor> processor;
	std::vector<script> pipelines;
	channels data; // what the scripts' sources show
	int slot = -1; // where it lies
};
} // namespace

task *scripts_create(const std::vector<std::string> &scripts, const std::string &folder, std::string &error)
{
	auto made = std::make_unique<scripts_task>();
	return made->start(scripts, folder, error) ? made.release() : nullptr;
}

bool scripts_test(std::string &error)
{
	char path[] = "/tmp/tmdempm-test-XXXXXX.py";
	int file = mkstemps(path, 3);
	const char text[] = "from paraview.simple import *\nfrom paraview import catalyst\noptions = catalyst.Options()\n"
						"def catalyst_execute(info):\n    print('tmdempm: executed')\n";
	bool written = file >= 0 && write(file, text, sizeof text - 1) == ssize_t(sizeof text - 1);
	if (file >= 0)
		close(file);
	bool works = false;
	if (!written) {
		error = "cannot write to /tmp";
	} else if (session_start(error)) {
		vtkNew<vtkCPProcessor> processor;
		vtkNew<vtkCPPythonScriptV2Pipeline> pipeline;
		vtkNew<vtkCPDataDescription> description;
		vtkNew<vtkPolyData> nothing;
		description->SetTimeData(0, 0);
		description->AddInput("points");
		works = processor->Initialize() && pipeline->Initialize(path) && processor->AddPipeline(pipeline);
		if (works && processor->RequestDataDescription(description)) {
			description->GetInputDescriptionByName("points")->SetGrid(nothing);
			works = processor->CoProcess(description);
		}
		if (!works)
			error = "ParaView's Python does not run a script (see the messages above): reinstall python3-paraview";
		processor->Finalize();
	}
	unlink(path);
	return works;
}
