// A live connection over the loop-back, both ends of it ours: a child plays the listening ParaView.
#include "catalyst.h"

#include <cstdio>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <vtkDoubleArray.h>
#include <vtkNetworkAccessManager.h>
#include <vtkPVTrivialProducer.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProcessModule.h>
#include <vtkSMSessionProxyManager.h>
#include <vtkSMSourceProxy.h>
#include <vtkTrivialProducer.h>

#include "live_link.h"
#include "session.h"

namespace
{
constexpr double SENT = 42.5;
constexpr int TRIES = 100; // of 0.1 s

bool port_free(int port)
{
	sockaddr_in address = {};
	address.sin_family = AF_INET;
	address.sin_port = htons(uint16_t(port));
	address.sin_addr.s_addr = htonl(INADDR_ANY);
	int s = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), yes = 1;
	setsockopt(s, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
	bool is = s >= 0 && bind(s, reinterpret_cast<sockaddr *>(&address), sizeof address) == 0;
	if (s >= 0)
		close(s);
	return is;
}

// The link takes a port and the next.
int free_ports()
{
	for (int port = 22300 + getpid() % 2000; port < 65000; port += 7)
		if (port_free(port) && port_free(port + 1))
			return port;
	return 0;
}

bool arrived(vtkTrivialProducer *extract)
{
	auto *data = vtkPolyData::SafeDownCast(extract->GetOutputDataObject(0));
	auto *array = data ? data->GetPointData()->GetArray("value") : nullptr;
	return array && array->GetNumberOfTuples() == 1 && array->GetComponent(0, 0) == SENT;
}

// The listening side: takes one extract; exit code 0 when it has come.
int listen_for_data(int port)
{
	std::string error;
	if (!session_start(error))
		return 1;
	vtkNew<live_link> link;
	vtkNew<vtkTrivialProducer> extract;
	vtkNew<vtkPolyData> nothing;
	extract->SetOutput(nothing);
	link->SetInsituPort(port);
	link->SetProcessType(vtkLiveInsituLink::LIVE);
	link->Initialize(nullptr);
	bool registered = false;
	vtkNetworkAccessManager *network = vtkProcessModule::GetProcessModule()->GetNetworkAccessManager();
	for (int k = 0; k < TRIES && !arrived(extract); k++) {
		network->ProcessEvents(100);
		if (link->connected() && !registered) {
			link->RegisterExtract(extract, "sources", "points", 0);
			registered = true;
		}
	}
	return arrived(extract) ? 0 : 1;
}

bool send_data(int port)
{
	std::string error;
	vtkSMSessionProxyManager *manager = session_start(error);
	vtkSMProxy *source = manager ? manager->NewProxy("sources", "PVTrivialProducer") : nullptr;
	if (!source)
		return false;
	source->UpdateVTKObjects();
	manager->RegisterProxy("sources", "points", source);
	vtkNew<vtkPolyData> data;
	vtkNew<vtkPoints> points;
	vtkNew<vtkDoubleArray> value;
	points->InsertNextPoint(0, 0, 0);
	value->SetName("value");
	value->InsertNextValue(SENT);
	data->SetPoints(points);
	data->GetPointData()->AddArray(value);
	vtkPVTrivialProducer::SafeDownCast(source->GetClientSideObject())->SetOutput(data, 0);
	vtkNew<live_link> link;
	link->SetHostname("127.0.0.1");
	link->SetInsituPort(port);
	link->SetProcessType(vtkLiveInsituLink::INSITU);
	bool once = false;
	for (int k = 0; k < TRIES && (link->connected() || !once); k++) {
		if (link->Initialize(manager)) {
			once = true;
			link->InsituUpdate(k, k);
			vtkSMSourceProxy::SafeDownCast(source)->UpdatePipeline(k);
			link->InsituPostProcess(k, k);
		}
		usleep(100000);
	}
	return once;
}
} // namespace

bool live_test(std::string &error)
{
	int port = free_ports();
	fflush(nullptr);
	pid_t listener = port ? fork() : -1;
	if (listener == 0) {
		alarm(30);
		_exit(listen_for_data(port));
	}
	int status = 1;
	bool connected = listener > 0 && send_data(port);
	if (listener > 0)
		waitpid(listener, &status, 0);
	if (connected && status == 0)
		return true;
	error = !port		 ? "no free port on the loop-back"
			: !connected ? "ParaView's live connection over the loop-back is not made: is lo up, and does the machine's "
						   "name (hostname) stand in /etc/hosts?"
						 : "a live connection is made over the loop-back, but no data comes";
	return false;
}
