#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataWriter.h>

#include "core/error.hpp"
#include "io/stl.hpp"

namespace porepack::io {
using namespace core;

namespace {

void write_poly_data(const Path& path, vtkPolyData* data) {
    write_whole(path, [&](const Path& name) {
        vtkNew<vtkXMLPolyDataWriter> writer;
        writer->SetFileName(name.c_str());
        writer->SetInputData(data);
        if (writer->Write() != 1 || writer->GetErrorCode() != 0)
            throw MachineError("cannot write " + path.string(), {.fix = "free some disk space or choose another folder with --output"});
    });
}

}  // namespace

void write_vtp(const Path& path, const TriangleSurface& surface) {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    for (const auto& p : surface.points) points->InsertNextPoint(p.data());
    vtkNew<vtkCellArray> cells;
    for (const auto& t : surface.triangles) {
        const vtkIdType corners[3] = {t[0], t[1], t[2]};
        cells->InsertNextCell(3, corners);
    }
    vtkNew<vtkPolyData> data;
    data->SetPoints(points);
    data->SetPolys(cells);
    write_poly_data(path, data);
}

void write_vtp(const Path& path, const std::vector<Line>& lines) {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    vtkNew<vtkCellArray> cells;
    for (const Line& line : lines) {
        cells->InsertNextCell(static_cast<int>(line.size()));
        for (const auto& p : line) cells->InsertCellPoint(points->InsertNextPoint(p.data()));
    }
    vtkNew<vtkPolyData> data;
    data->SetPoints(points);
    data->SetLines(cells);
    write_poly_data(path, data);
}

}  // namespace porepack::io
